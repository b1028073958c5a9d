//! Wall shear stress measures, volumes and periodicity; does not know where the fields came from.

pub mod shear;
