function out = get_param(block, name)
assert(any(strcmp(block, note('').blocks)), ['no block ' block]);
switch name
    case 'ModelWorkspace'
        keep = @(key, value) note('field', ['WORKSPACE ' key ' ' shown(value)]);
        out = struct('assignin', keep);
    case 'FunctionPortSpecification'
        out = struct('InputArguments', repmat(struct('Scope', 'Input'), 1, 4));
end
end

function text = shown(value)
numbers = @(name) [name sprintf(':%.17g', value.(name))];
text = strjoin(cellfun(numbers, fieldnames(value), 'UniformOutput', false)', ' ');
end
