use super::*;

fn sheet(text: &str) -> Sheet {
    Sheet::parse(text, 2, |names| names[0].to_lowercase().starts_with('t'))
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn numbers(sheet: &Sheet) -> Vec<Vec<f64>> {
    let numbers = |row: &Row| (0..2).map(|i| sheet.number(row, i).unwrap()).collect();
    sheet.rows.iter().map(numbers).collect()
}

#[test]
fn the_same_table_in_all_shapes_is_the_same() {
    let expected = [[0.0, 5.5], [0.05, -6.25], [0.1, 6.0]].map(Vec::from);
    for (text, shape) in [
        ("0.0,5.5\n0.05,-6.25\n0.1,6\n", "commas"),
        ("t,Q\n0.0,5.5\n0.05,-6.25\n0.1,6\n", "commas"),
        ("t,Q\r\n0.0,5.5\r\n\r\n0.05,-6.25\r\n0.1,6\r\n", "commas"),
        ("t,Q\r0.0,5.5\r0.05,-6.25\r0.1,6\r", "commas"),
        (
            "\u{feff}\"t\",\"Q\"\n\"0.0\",\"5.5\"\n\"0.05\",\"-6.25\"\n\"0.1\",\"6\"\n",
            "commas",
        ),
        (
            "t;Q\n0,0;5,5\n0,05;-6,25\n0,1;6\n",
            "semicolons, decimal commas",
        ),
        (
            "sep=;\nt;Q\n0,0;5,5\n0,05;-6,25\n0,1;6\n",
            "semicolons, decimal commas",
        ),
        ("t;Q;\n0.0;5.5;\n0.05;-6.25;\n0.1;6;\n", "semicolons"),
        (
            "\"t\",\"Q\"\n\"0,0\",\"5,5\"\n\"0,05\",\"-6,25\"\n\"0,1\",\"6\"\n",
            "commas, decimal commas",
        ),
        (
            "t (s)\tQ (ml/s)\n0,0\t5,5\n0,05\t-6,25\n0,1\t6\n",
            "tabs, decimal commas",
        ),
        (
            "t (s) Q (ml/s)\n0.0   5.5\n0.05\t-6.25\n 0.1  6\n",
            "blanks",
        ),
        ("t [s],Q [ml / s]\n0.0 5.5\n0.05 -6.25\n0.1 6\n", "blanks"),
        ("0,0 5,5\n0,05 -6,25\n0,1 6\n", "blanks, decimal commas"),
        ("t | Q\n0.0 | 5.5\n0.05 | -6.25\n0.1 | 6\n", "bars"),
        ("3 2\n0.0 5.5\n0.05 -6.25\n0.1 6\n", "blanks"),
        ("3\nt Q\n0.0 5.5\n0.05 -6.25\n0.1 6\n", "blanks"),
        (
            "Patient: 7\nDate;today\nt;Q\ns;ml/s\n0.0;5.5\n0.05;-6.25\n0.1;6\n",
            "semicolons",
        ),
        (
            "# made by hand\n# t, Q\n0.0 5.5\n0.05 -6.25\n0.1 6 # the last\n"
                .split(" # the")
                .next()
                .unwrap(),
            "blanks",
        ),
        ("%t Q\n0.0D0 5.5D+0\n5.0d-2 -6.25E0\n1e-1 +6.\n", "blanks"),
        ("t,Q\n0.0,5.5\n0.05,\u{2212}6.25\n0.1,6\n", "commas"),
        (
            "t,Q\n0.0, 5.5\n0.05 ,-6.25\n\u{a0}0.1,6\u{a0}\n,\n",
            "commas",
        ),
    ] {
        let sheet = sheet(text);
        assert_eq!(numbers(&sheet), expected, "{text:?}");
        assert_eq!(
            sheet.shape(),
            format!("3 rows, columns separated by {shape}"),
            "{text:?}"
        );
    }
}

#[test]
fn names_and_units_stand_where_people_put_them() {
    let flow = |text: &str| {
        sheet(text)
            .unit(1, units::FLOW)
            .unwrap()
            .map(|unit| unit.size)
    };
    let millilitre = Some(1e-6);
    for text in [
        "t (s),Q (mL/sec)\n0,1\n1,2\n",
        "time,flow\ns,ml/s\n0,1\n1,2\n",
        "time,flow\n(s),(cm³/s)\n0,1\n1,2\n",
        "time\tflow\n[s]\t[cm3/s]\n0\t1\n1\t2\n",
        "#\n# time\tflow  \n#  (s)\t(cm^3/sec)\n#\n0\t1\n1\t2\n",
        "# time flow\n# (s) (cm^3/sec)\n0 1\n1 2\n",
        "# t [s], Q [ml/s]\n0 1\n1 2\n",
        "#  Time (sec)   Flow (cm^3/sec)\n0   1\n1 2\n",
    ] {
        assert_eq!(flow(text), millilitre, "{text:?}");
    }
    let noted = sheet("# inflow of subject 3 in mm^3/s\n0 1\n1 2\n");
    assert_eq!(noted.noted_unit(units::FLOW).unwrap().size, 1e-9);
    let third = sheet("time_s,flow_ml_s,sd\n0,1,0.1\n1,2,\n");
    assert_eq!(third.columns[2].name, "sd");
    let pandas = sheet(",time,flow\n0,0.0,1\n1,0.5,2\n");
    assert_eq!(pandas.columns[1].name, "time");
    let of_r = sheet("\"time\" \"flow\"\n\"1\" 0.0 1\n\"2\" 0.5 2\n");
    assert_eq!(
        (of_r.columns.len(), of_r.columns[1].name.as_str()),
        (3, "time")
    );
}

#[test]
fn files_that_are_not_tables_are_refused_with_the_line() {
    #[rustfmt::skip]
    let faults = [
        ("t,Q\n0,x\n1,2\n", Some(2), "expected a number, found \"x\""),
        ("t,Q\n0,1\n1,x\n", Some(3), "expected a number, found \"x\""),
        ("t,Q\n0,1\n1,\n", Some(3), "expected 2 numbers, found 1"),
        ("t,Q\n0,1\n1,2,3\n", Some(3), "expected 2 numbers, found 3"),
        ("t,Q,p\n0,1,2,3\n1,2,3,4\n", Some(1), "expected names of 4 columns"),
        ("t;Q\n0,5;1.5\n1,0;2\n", Some(2), "line 2 has a comma within a number and line 2 a point"),
        ("t;Q\n0;1.234,5\n1;2,5\n", Some(2), "no marks between thousands"),
        ("4 2\n0 1\n1 2\n2 3\n", Some(1), "seems to count the rows, 4, but 3 follow"),
        ("t,Q\n0,1\nMean: 3\n", Some(3), "expected 2 numbers, found 1"),
    ];
    for (text, line, expected) in faults {
        let found = Sheet::parse(text, 2, |_| true);
        let fault = match found {
            Err(fault) => fault,
            Ok(sheet) => {
                let all = sheet
                    .rows
                    .iter()
                    .map(|row| sheet.number(row, 0).and(sheet.number(row, 1)));
                all.filter_map(Result::err)
                    .next()
                    .unwrap_or_else(|| panic!("{text:?}"))
            }
        };
        assert_eq!(fault.line, line, "{text:?}: {fault}");
        assert!(fault.message.contains(expected), "{text:?}: {fault}");
    }
}
