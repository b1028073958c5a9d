use super::*;

#[test]
fn files_that_are_not_polydata_are_refused() {
    let head = r#"<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">"#;
    let file = |points: &str, offsets: &str| {
        format!(
            "{head}<PolyData><Piece NumberOfPoints=\"2\" NumberOfLines=\"1\"><Points><DataArray type=\"Float32\" \
             NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points><Lines><DataArray type=\"Int32\" \
             Name=\"connectivity\">0 1</DataArray><DataArray type=\"Int32\" Name=\"offsets\">{offsets}</DataArray></Lines>\
             </Piece></PolyData></VTKFile>"
        )
    };
    let good = read(file("0 0 0 1 2 3", "2").as_bytes()).unwrap();
    assert_eq!(
        (good.points[1], &good.lines[0][..]),
        ([1.0, 2.0, 3.0], &[0, 1][..])
    );
    let grid = head.replace("PolyData", "UnstructuredGrid") + "</VTKFile>";
    let compressed = head.replace(
        "byte_order",
        "compressor=\"vtkLZ4DataCompressor\" byte_order",
    );
    let whole = file("0 0 0 1 2 3", "2");
    #[rustfmt::skip]
    let mistakes = [
        (file("0 0 0 1 2", "2"), "has 5 numbers, and 6 were announced"),
        (file("0 0 0 1 2 x", "2"), "\"x\" is not a number"),
        (file("0 0 0 1 2 3", "3"), "do not fit its connectivity"),
        (file("0 0 0 1 2 3", "2 4"), "\"offsets\" in <Lines> has 2 numbers"),
        (file("0 0 0 1 2 3", "2").replace("0 1</", "0 2</"), "names point 2, and there are 2"),
        (grid, "found UnstructuredGrid"),
        (compressed, "compressed by vtkLZ4DataCompressor"),
        ("solid x".into(), "no <VTKFile>"),
        (whole[..whole.len() - 20].to_owned(), "cut off"),
        (whole.replace("format=\"ascii\"", "format=\"binary\""), "base64"),
    ];
    for (text, message) in mistakes {
        let error = read(text.as_bytes()).unwrap_err();
        assert!(
            error.message.contains(message),
            "{error}\nexpected {message}"
        );
    }
}
