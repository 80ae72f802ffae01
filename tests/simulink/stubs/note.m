function out = note(kind, varargin)
% Take note of a call, and give all notes back: names of blocks, and lines.
persistent blocks lines
if isempty(blocks), blocks = {}; lines = {}; end
switch kind
    case 'block', blocks{end + 1} = varargin{1};
    case 'line', lines{end + 1} = varargin{1};
end
out = struct('blocks', {blocks}, 'lines', {lines});
end
