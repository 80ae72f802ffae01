function new_system(model)
note('block', model);
end
