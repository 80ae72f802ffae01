function mask = create(block)
assert(any(strcmp(block, note('').blocks)), ['no block ' block]);
mask = struct('addParameter', @keep);
end

function keep(varargin)
set = struct(varargin{:});
assert(isvarname(set.Name) && strcmp(set.Tunable, 'on'));
value = eval(set.Value);
note('field', ['FIELD ' set.Name sprintf(' %.17g', value)]);
end
