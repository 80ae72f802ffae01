function save_system(model)
taken = note('');
printf('%s\n', taken.lines{:}, taken.fields{:});
end
