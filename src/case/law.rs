//! The materials of a case as the structural solver takes them.

use super::Material;
use fsi_pfem::material::{
    HolzapfelGasserOgden, KelvinVoigt, Law, LinearElastic, NeoHooke, SaintVenantKirchhoff,
};
use std::sync::Arc;

impl From<&Material> for Law {
    fn from(material: &Material) -> Self {
        let (elastic, viscosity): (Arc<dyn fsi_pfem::material::HyperelasticMaterial>, _) =
            match *material {
                Material::NeoHooke {
                    mu,
                    kappa,
                    viscosity,
                } => (Arc::new(NeoHooke { mu, kappa }), viscosity),
                Material::HolzapfelGasserOgden {
                    mu,
                    kappa,
                    k1,
                    k2,
                    fibre_angle_deg,
                    dispersion,
                    tension_only,
                    viscosity,
                } => {
                    let (sin, cos) = (
                        fibre_angle_deg.to_radians().sin(),
                        fibre_angle_deg.to_radians().cos(),
                    );
                    let elastic = HolzapfelGasserOgden {
                        mu,
                        kappa,
                        k1,
                        k2,
                        fibre: [cos, sin],
                        dispersion: dispersion.unwrap_or(0.0),
                        tension_only,
                    };
                    (Arc::new(elastic), viscosity)
                }
                Material::SaintVenantKirchhoff {
                    youngs_modulus,
                    poisson_ratio,
                    viscosity,
                } => {
                    let elastic = SaintVenantKirchhoff::new(youngs_modulus, poisson_ratio);
                    (Arc::new(elastic), viscosity)
                }
                Material::LinearElastic {
                    youngs_modulus,
                    poisson_ratio,
                } => (
                    Arc::new(LinearElastic::new(youngs_modulus, poisson_ratio)),
                    None,
                ),
            };
        let viscosity = viscosity.filter(|&viscosity| viscosity > 0.0);
        Self {
            elastic,
            viscous: viscosity.map(|viscosity| KelvinVoigt { viscosity }),
        }
    }
}
