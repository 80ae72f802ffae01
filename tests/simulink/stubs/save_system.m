function save_system(model)
lines = note('').lines;
printf('%s\n', lines{:});
end
