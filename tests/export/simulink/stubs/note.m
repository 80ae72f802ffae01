function out = note(kind, varargin)
% Take note of a call, and give all notes back: names of blocks, lines, and what was set.
persistent blocks lines fields
if isempty(blocks), blocks = {}; lines = {}; fields = {}; end
switch kind
    case 'block', blocks{end + 1} = varargin{1};
    case 'line', lines{end + 1} = varargin{1};
    case 'field', fields{end + 1} = varargin{1};
end
out = struct('blocks', {blocks}, 'lines', {lines}, 'fields', {fields});
end
