function out = get_param(block, name)
assert(any(strcmp(block, note('').blocks)), ['no block ' block]);
switch name
    case 'ModelWorkspace'
        keep = @(key, value) note('field', ['WORKSPACE ' key ' ' disp(sizes(value))]);
        out = struct('assignin', keep);
    case 'FunctionPortSpecification'
        out = struct('InputArguments', repmat(struct('Scope', 'Input'), 1, 4));
end
end

function text = sizes(value)
names = fieldnames(value);
text = strjoin(cellfun(@(n) sprintf('%s:%d', n, numel(value.(n))), names, ...
                       'UniformOutput', false)', ' ');
end
