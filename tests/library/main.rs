//! What needs the library and the command line alone: no solver is started.

mod architecture;
mod case_bad_input;
mod case_fuzz;
mod case_load;
mod check_wall;
mod convergence_study;
mod coupling_cases;
mod coupling_loop;
mod coupling_models;
mod coupling_noise;
mod geometry_flag;
mod geometry_fluid;
mod geometry_vessel;
mod geometry_wall;
mod keys;
mod native_failures;
mod native_flow;
mod native_tube;
mod pfem_benchmarks;
mod pfem_dynamics;
mod pfem_locking;
mod pfem_spaces;
mod pfem_stability;
mod pfem_static_tube;
#[path = "../pfem_support/mod.rs"]
mod pfem_support;
mod prestress;
mod solid_bad_input;
mod solid_dynamic;
mod solid_state;
mod solid_static;
mod solid_support;
mod tissue;
mod vessel;
mod windkessel;
