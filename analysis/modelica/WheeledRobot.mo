within;
package WheeledRobot "Reference, control law and robot as imported FMUs, wired"
  annotation(Documentation(info = "<html><p>Import wmr_reference, wmr_nn and wmr_plant first
    (FMI 2.0, co-simulation, communication step 0.01 s), then redeclare the three partial blocks with
    the classes that the import made. Their ports have the names below.</p></html>"));

  partial block Reference "Desired trajectory"
    output Real x_d(unit = "m");
    output Real y_d(unit = "m");
    output Real theta_d(unit = "rad");
    output Real v1_d(unit = "m/s");
    output Real v2_d(unit = "rad/s");
    output Real v1_d_dot(unit = "m/s2");
    output Real v2_d_dot(unit = "rad/s2");
  end Reference;

  partial block Controller "Control law, sampled with its own period"
    input Real x_d(unit = "m");
    input Real y_d(unit = "m");
    input Real theta_d(unit = "rad");
    input Real v1_d(unit = "m/s");
    input Real v2_d(unit = "rad/s");
    input Real v1_d_dot(unit = "m/s2");
    input Real v2_d_dot(unit = "rad/s2");
    input Real x(unit = "m");
    input Real y(unit = "m");
    input Real theta(unit = "rad");
    input Real v1(unit = "m/s");
    input Real omega(unit = "rad/s");
    output Real tau_right(unit = "N.m");
    output Real tau_left(unit = "N.m");
  end Controller;

  partial block Plant "Wheeled robot"
    input Real tau_right(unit = "N.m");
    input Real tau_left(unit = "N.m");
    input Real noise_right(unit = "N.m");
    input Real noise_left(unit = "N.m");
    output Real x(unit = "m");
    output Real y(unit = "m");
    output Real theta(unit = "rad");
    output Real v1(unit = "m/s");
    output Real omega(unit = "rad/s");
  end Plant;

  partial model Loop "The closed loop; one sample of delay in the torque destroys the model-based law"
    replaceable Reference reference;
    replaceable Controller controller;
    replaceable Plant plant;
  equation
    controller.x_d = reference.x_d;
    controller.y_d = reference.y_d;
    controller.theta_d = reference.theta_d;
    controller.v1_d = reference.v1_d;
    controller.v2_d = reference.v2_d;
    controller.v1_d_dot = reference.v1_d_dot;
    controller.v2_d_dot = reference.v2_d_dot;
    controller.x = plant.x;
    controller.y = plant.y;
    controller.theta = plant.theta;
    controller.v1 = plant.v1;
    controller.omega = plant.omega;
    plant.tau_right = controller.tau_right;
    plant.tau_left = controller.tau_left;
    plant.noise_right = 0;
    plant.noise_left = 0;
    annotation(experiment(StartTime = 0, StopTime = 80, Interval = 0.01));
  end Loop;

  model Imported "Loop with the classes that an import of the three FMUs makes"
    extends Loop(
      redeclare wmr_reference_fmu reference,
      redeclare wmr_nn_fmu controller,
      redeclare wmr_plant_fmu plant);
    annotation(experiment(StartTime = 0, StopTime = 80, Interval = 0.01));
  end Imported;
end WheeledRobot;
