function set_param(block, varargin)
assert(any(strcmp(block, note('').blocks)), ['no block ' block]);
assert(mod(numel(varargin), 2) == 0);
end
