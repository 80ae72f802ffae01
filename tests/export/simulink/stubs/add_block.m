function add_block(source, block, varargin)
assert(ischar(source) && mod(numel(varargin), 2) == 0);
assert(~any(strcmp(block, note('').blocks)), ['twice: ' block]);
note('block', block);
end
