function set_param(block, varargin)
assert(any(strcmp(block, note('').blocks)), ['no block ' block]);
assert(mod(numel(varargin), 2) == 0);
set = struct(varargin{:});
if isfield(set, 'Parameters')
    note('field', ['PARAMETERS ' set.FunctionName ' ' set.Parameters]);
end
end
