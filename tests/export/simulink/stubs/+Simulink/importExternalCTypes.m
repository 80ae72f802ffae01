function importExternalCTypes(header)
assert(exist(fullfile(pwd, header), 'file') == 2);
end
