function simulink_results()
% Simulink: the closed loop's FMU, and the kit's loop of two FMUs and an S-function.
% Run in the root of the checkout with exports/ there; writes loop.csv and kit.csv.
here = pwd;
shown = {'x', 'y', 'theta', 'v1', 'omega'};

fmu = fullfile(here, 'exports', 'wmr_closed-loop.fmi2.fmu');
new_system('alone');
set_param('alone', 'Solver', 'FixedStepDiscrete', 'FixedStep', '0.01', 'StopTime', '2');
add_block('simulink_extras/FMU Import/FMU', 'alone/loop', 'FMUName', fmu);
set_param('alone/loop', 'FMUSampleTime', '0.01');
record('alone', 'loop', outputs_of(fmu), shown, fullfile(here, 'loop.csv'));

cd(fullfile(here, 'exports', 'kit'));
mex sfun_wmr_mb.c wmr_mb.c
wmr_loop('wmr', fullfile(here, 'exports'));
set_param('wmr', 'StopTime', '2');
motion = {'x', 'y', 'theta', 'v1', 'omega', 'psi'};
record('wmr', 'plant', motion, shown, fullfile(here, 'kit.csv'));
cd(here);
end

function record(model, block, outputs, shown, file)
% Runs the model and writes the named outputs of the block at each sample.
for k = 1:numel(shown)
    sink = ['to_' shown{k}];
    add_block('simulink/Sinks/To Workspace', [model '/' sink], ...
              'VariableName', sink, 'SaveFormat', 'Timeseries');
    port = find(strcmp(shown{k}, outputs));
    add_line(model, sprintf('%s/%d', block, port), [sink '/1'], 'autorouting', 'on');
end
result = sim(model, 'ReturnWorkspaceOutputs', 'on');
columns = arrayfun(@(k) result.get(['to_' shown{k}]).Data(:), 1:numel(shown), ...
                   'UniformOutput', false);
times = result.get(['to_' shown{1}]).Time(:);
writetable(array2table([times, columns{:}], 'VariableNames', [{'time'}, shown]), file);
end

function names = outputs_of(fmu)
% Names of the outputs in the order of the model description, which is that of the ports.
folder = tempname;
unzip(fmu, folder);
variables = xmlread(fullfile(folder, 'modelDescription.xml')).getElementsByTagName('ScalarVariable');
names = {};
for k = 0:variables.getLength() - 1
    if strcmp(variables.item(k).getAttribute('causality'), 'output')
        names{end + 1} = char(variables.item(k).getAttribute('name')); %#ok<AGROW>
    end
end
end
