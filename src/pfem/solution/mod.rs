//! Equilibria and motions: Newton's method, static analysis with its bifurcations, dynamics.

mod anderson;
mod equation_of_motion;
pub mod listener;
pub mod modes;
pub mod newton;
pub mod quasi_newton;
mod renewal;
pub mod stability;
mod stability_watch;
pub mod statics;
pub mod stats;
pub mod structure;
pub mod time_scheme;
pub mod unloaded;
