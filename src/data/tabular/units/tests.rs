use super::*;

#[test]
fn usual_spellings_are_understood() {
    #[rustfmt::skip]
    let known: [(f64, Dimension, &[&str]); 14] = [
        (1e-6, FLOW, &[
            "ml/s", "mL/s", "ml/sec", "mL / sec", "cm3/s", "cm³/s", "cm^3/s", "cm**3/s", "cm^{3}/s", "$cm^3/s$", "cc/s", "cc/sec",
            "ccm/s", "cm3 s-1", "cm³ s⁻¹", "cm³·s⁻¹", "ml.s-1", "ml per second", "(mL/s)", "[cm3/s]", "mls", "milliliters/second",
            "cm³\u{a0}s⁻¹", "ML/S", "10^-6 m^3/s", "1e-6 m3/s", "×10⁻⁶ m³ s⁻¹",
        ]),
        (1e-6 / 60.0, FLOW, &[
            "ml/min", "mL/min", "cc/min", "cm3/min", "mlmin", "ml min-1", "cm³ min⁻¹", "ml per minute", "Millilitres/Minute",
        ]),
        (1e-3 / 60.0, FLOW, &["l/min", "L/min", "LPM", "lpm", "litres per minute", "L min-1", "dm3/min", "ℓ/min"]),
        (1e-9, FLOW, &["mm3/s", "mm^3/sec", "mm³/s", "µl/s", "μl/s", "uL/s", "mm³·s⁻¹"]),
        (1.0, FLOW, &["m3/s", "m³/s", "m^3/s", "m3 s-1", "m3s", "meters^3/secs"]),
        (1e-3, FLOW, &["l/s", "L/s", "dm³/s"]),
        (133.322, PRESSURE, &["mmHg", "mm Hg", "mmhg", "MMHG", "torr", "[mmHg]"]),
        (98.0665, PRESSURE, &["cmH2O", "cm H2O", "cm H₂O", "cmh2o"]),
        (0.1, PRESSURE, &["dyn/cm2", "dyn/cm²", "dyne/cm^2", "dynes/cm2", "dyn cm-2", "Ba", "barye"]),
        (1.0, PRESSURE, &["Pa", "pa", "pascals", "N/m2", "N/m²", "N m-2", "kg m-1 s-2"]),
        (1e3, PRESSURE, &["kPa", "kpa", "KPA"]),
        (1e6, PRESSURE, &["MPa", "N/mm2", "N/mm^2"]),
        (1e-3, PRESSURE, &["mPa"]),
        (100.0, PRESSURE, &["mbar", "hPa"]),
    ];
    for (size, dimension, words) in known {
        for word in words {
            let unit = Unit::parse(word).unwrap_or_else(|| panic!("{word}"));
            assert_eq!(unit.dimension, dimension, "{word}");
            let error = unit.size / size - 1.0;
            assert!(error.abs() < 1e-12, "{word}: {}", unit.size);
        }
    }
    let micro = ["um", "µm", "μm", "micron"].map(|word| Unit::parse(word).unwrap());
    let (size, dimension) = (1e-6, LENGTH);
    assert!(micro.iter().all(|unit| *unit == Unit { size, dimension }));
    for word in [
        "", "-", "1", "MPA", "gal/min", "left", "ml//s x", "s/s", "m99", "ml/", "3", "Pas", "kPas",
        "mmHgs",
    ] {
        let found = Unit::parse(word);
        assert!(found.is_none() || word == "ml/", "{word}: {found:?}");
    }
    assert_eq!(Unit::parse("cm/s").unwrap().dimension, VELOCITY);
}

#[test]
fn names_of_columns_end_with_units() {
    for (name, wanted, size) in [
        ("flow_ml_min", FLOW, 1e-6 / 60.0),
        ("flow_m3_s", FLOW, 1.0),
        ("flow_cm3_per_s", FLOW, 1e-6),
        ("Q (mL/sec)", FLOW, 1e-6),
        ("Q(left) [ml/s]", FLOW, 1e-6),
        ("Flow rate, ml/s", FLOW, 1e-6),
        ("Q / ml/min", FLOW, 1e-6 / 60.0),
        ("flow in cm³/s", FLOW, 1e-6),
        ("p mmHg", PRESSURE, 133.322),
        ("pressure_dyn_cm2", PRESSURE, 0.1),
        ("p_cmH2O", PRESSURE, 98.0665),
        ("time_ms", TIME, 1e-3),
        ("t / s", TIME, 1.0),
        ("Time[sec]", TIME, 1.0),
        ("x_mm", LENGTH, 1e-3),
        ("Radius (µm)", LENGTH, 1e-6),
    ] {
        let unit = Unit::of_name(name, wanted).unwrap();
        let unit = unit.unwrap_or_else(|| panic!("{name}"));
        assert!(
            (unit.size / size - 1.0).abs() < 1e-12,
            "{name}: {}",
            unit.size
        );
    }
    for name in ["Q", "Q_l", "flow_in", "Q (left)", "time_s", "Q_m"] {
        assert_eq!(Unit::of_name(name, FLOW), Ok(None), "{name}");
    }
    for (name, found) in [
        ("Q (gal/min)", "gal/min"),
        ("v (cm/s)", "cm/s"),
        ("p (mmHg)", "mmHg"),
    ] {
        assert_eq!(
            Unit::of_name(name, FLOW),
            Err(ForeignUnit {
                text: found.to_owned(),
                wanted: FLOW
            })
        );
    }
    let unit = Unit::within("inflow of subject 12 in mm^3/s, period 0.8 s", FLOW).unwrap();
    assert_eq!(unit.size, 1e-9);
    assert_eq!(Unit::within("ml/s or ml/min", FLOW), None);
}
