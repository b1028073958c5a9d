//! What starts solvers: runs, and all that looks at what runs leave.

mod bench;
mod benchmark_elastic_tube;
mod benchmark_neo_hookean_tube;
mod benchmark_pulse_wave;
mod benchmark_rigid_tube;
mod benchmark_support;
mod benchmark_turek_hron;
mod benchmark_womersley_elastic;
mod boundary_conditions;
mod browser;
mod buckling;
mod check;
mod coupled_run;
mod cross_check;
mod damaged_results;
mod diverging_flow;
mod fault_campaign;
mod fluid_faults;
mod fluid_hostile;
mod fluid_second_order;
mod fluid_step;
mod fluid_support;
mod fluid_transport;
mod geometry_check_mesh;
mod hemodynamics;
mod installed;
#[cfg(target_arch = "x86_64")]
mod io_faults;
mod native_fields;
mod native_run;
mod openfoam_versions;
mod own_case;
mod own_fluid;
mod own_mesh;
mod pages;
#[path = "../pfem_support/mod.rs"]
mod pfem_support;
mod probes;
mod python_reader;
mod report;
mod resolution;
mod resume;
mod rigid_vessel;
mod run_support;
mod simulation;
mod study;
mod tables;
mod terminal;
mod tethered_wave;
mod trees;

mod validation;
mod vessel;
mod wall_state;
