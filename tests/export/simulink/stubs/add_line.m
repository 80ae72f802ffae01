function add_line(model, from, to, varargin)
for port = {from, to}
    name = strtok(port{1}, '/');
    assert(any(strcmp([model '/' name], note('').blocks)), ['no block ' name]);
end
note('line', [from ' ' to]);
end
