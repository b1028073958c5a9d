//! An artery that buckles sideways at 15.3 kPa (`docs/wall.md`), narrower and thinner than that of the defaults.

/// Keys of the models that make it.
pub const NEAR_BUCKLING: [(&str, &str); 5] = [
    ("geometry.graft_inner_radius_m", "3.0e-3"),
    ("geometry.artery_inner_radius_m", "2.35e-3"),
    ("geometry.media_thickness_m", "0.45e-3"),
    ("geometry.adventitia_thickness_m", "0.45e-3"),
    (
        "geometry.imperfection",
        "[[0,0,0,0,0],[0.25,0.95,0.3,0.85,0.75],[0.75,0.6,0.1,0.45,0.9],[0.25,0.5,0.8,1,0.85],\
         [0.6,0.85,0.85,0.45,0.25],[0.25,0.45,0.65,0.15,0.1],[0,0,0,0,0]]",
    ),
];
