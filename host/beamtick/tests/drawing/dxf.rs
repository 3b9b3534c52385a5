//! Drawings in DXF.
use super::*;

#[test]
fn a_dxf_whose_shapes_have_heights_says_that_they_are_flat_here() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (to, says) in [("7", true), ("0", false)] {
        let line = format!("0\nLINE\n8\n0\n62\n1\n10\n0\n20\n0\n30\n0\n11\n10\n21\n0\n31\n{to}\n");
        let dxf = format!("0\nSECTION\n2\nENTITIES\n{line}0\nENDSEC\n0\nEOF\n");
        fs::write(folder.path().join("z.dxf"), dxf).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "z.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 10.000 mm"), "{said}");
        let note = "z.dxf: note: shapes at several Z are marked in the plane of X and Y (1)";
        assert_eq!(said.contains(note), says, "{said}");
    }
}

/// Nor have names of blocks; of two that differ in case, the one that is written so is inserted.
#[test]
fn names_of_blocks_have_no_case() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let block = |name: &str, mm: u32| {
        let line = format!("0\nLINE\n8\n0\n62\n1\n10\n0\n20\n0\n11\n{mm}\n21\n0\n");
        format!("0\nBLOCK\n2\n{name}\n10\n0\n20\n0\n{line}0\nENDBLK\n8\n0\n")
    };
    for (blocks, inserted, says) in [
        (vec![block("Bracket", 7)], "BRACKET", "marks of 7.000 mm"),
        (vec![block("\u{c4}", 7)], "\u{e4}", "marks of 7.000 mm"),
        (vec![block("a", 7), block("A", 9)], "a", "marks of 7.000 mm"),
        (vec![block("a", 7), block("A", 9)], "A", "marks of 9.000 mm"),
        (vec![block("a", 7)], "b", "the block `b` does not exist"),
        (vec!["0\nBLOCK\n2\nA\n10\n0\n20\n0\n0\nINSERT\n2\na\n0\nENDBLK\n".to_owned()], "A", "the block `a` does not"),
    ] {
        let insert = format!("0\nINSERT\n8\n0\n2\n{inserted}\n10\n0\n20\n0\n");
        let drawing = format!("0\nSECTION\n2\nBLOCKS\n{}0\nENDSEC\n{}", blocks.concat(), dxf(&[], &insert));
        fs::write(folder.path().join("d.dxf"), drawing).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
        assert!(said.contains(says) && (code == 0) == says.starts_with("marks"), "{inserted}: {said}");
    }
}

/// A DXF with layers (name, other groups) and entities.
fn dxf(layers: &[(&str, &str)], entities: &str) -> String {
    let rows: String = layers.iter().map(|(name, groups)| format!("0\nLAYER\n2\n{name}\n{groups}")).collect();
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n{rows}0\nENDTAB\n\
         0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

/// AutoCAD's names have no case: of layers that are off, frozen or not plotted, of those of the
/// machine file, and of those whose ends meet.
#[test]
fn names_of_layers_have_no_case() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let line =
        |layer: &str, y: u32, to: u32| format!("0\nLINE\n8\n{layer}\n62\n1\n10\n0\n20\n{y}\n11\n{to}\n21\n{y}\n");
    let off = "on a layer that is off or frozen is not marked (1)";
    let unplotted = "what is on a layer that is not plotted is not marked (1)";
    for (layers, layer, says) in [
        (&[("A", "70\n1\n")][..], "a", off),
        (&[("a", "62\n-7\n")], "A", off),
        (&[("\u{c4}u\u{df}en", "70\n1\n")], "\u{e4}u\u{df}EN", off),
        (&[("A", "290\n0\n")], "A", unplotted),
        (&[("A", "290\n0\n")], "a", unplotted),
        // A program whose names have a case.
        (&[("A", ""), ("a", "70\n1\n")], "a", off),
        (&[("Aa", ""), ("aA", "70\n1\n")], "aa", off),
    ] {
        let drawing = dxf(layers, &(line(layer, 5, 9) + &line("B", 0, 3)));
        fs::write(folder.path().join("d.dxf"), drawing).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 3.000 mm"), "{layers:?} {layer}: {said}");
        assert!(said.contains(says), "{layers:?} {layer}: {said}");
    }
    for (layers, layer) in [(&[("A", "290\n1\n")][..], "a"), (&[("A", "70\n1\n"), ("a", "")], "a")] {
        fs::write(folder.path().join("d.dxf"), dxf(layers, &line(layer, 5, 9))).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 9.000 mm") && !said.contains("not marked"), "{layers:?}: {said}");
    }
    // Of the machine file, and of ends that meet.
    let corner = "0\nLINE\n8\nCut\n62\n1\n10\n9\n20\n5\n11\n9\n21\n0\n";
    fs::write(folder.path().join("d.dxf"), dxf(&[], &(line("cUT", 5, 9) + corner))).unwrap();
    let only = ["--layer", "layer=CUT,power=5,speed=900"];
    let words = [&["import", "d.dxf", "--machine", "m.toml", "-o", "d.gts"][..], &only].concat();
    let (said, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{said}");
    let job = fs::read_to_string(folder.path().join("d.gts")).unwrap();
    assert_eq!(job.matches("BufLaserOn").count(), 1, "one shape\n{job}");
    // What is invisible is not on a layer that is off.
    fs::write(folder.path().join("d.dxf"), dxf(&[], &(line("A", 5, 9) + &line("A\n60\n1", 0, 3)))).unwrap();
    let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
    assert!(code == 0 && said.contains("what is invisible is not marked (1)"), "{said}");
}

/// Bulges of a rounding, and of arcs so flat that their centres are kilometres away.
#[test]
fn flat_arcs_of_a_dxf_are_marked_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (bulge, chord, sagitta) in [
        ("1e-7", 10.0, 0.0),
        ("-1e-7", 10.0, 0.0),
        ("5e-324", 10.0, 0.0),
        ("1e-5", 10.0, 0.0),
        ("4e-4", 200.0, 0.04),
        ("-5e-5", 350.0, -0.00875),
    ] {
        let entities = format!("0\nLWPOLYLINE\n62\n1\n90\n2\n70\n0\n10\n0\n20\n1\n42\n{bulge}\n10\n{chord}\n20\n1\n");
        fs::write(folder.path().join("d.dxf"), dxf(&[], &entities)).unwrap();
        let words = ["sim", "d.dxf", "--machine", "m.toml", "--tick-us", "100", "--trace", "t.csv", "--strict"];
        let (said, code) = beamtick(folder.path(), &words);
        assert_eq!(code, 0, "{bulge}: {said}");
        let count = 4000;
        let points = (0..=count).map(|k| {
            let t = f64::from(k) / f64::from(count);
            [chord * t, 1.0 - 4.0 * sagitta * t * (1.0 - t)]
        });
        let what = format!("the bulge {bulge}");
        let mark = Mark { points: points.collect(), red: true, what, corners: Vec::new() };
        differs(&[mark], &rows(&folder.path().join("t.csv"))).unwrap_or_else(|why| panic!("{bulge}: {why}"));
    }
}

/// Lines, arcs, circles, polylines with bulges, an ellipse, splines and a block, written by another
/// program, which also evaluated their points (ezdxf; those of circles by sine and cosine).
#[test]
fn a_dxf_is_marked_where_another_program_says() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    fs::write(folder.path().join("plate.dxf"), include_str!("plate.dxf")).unwrap();
    let mut marks: Vec<Mark> = Vec::new();
    for line in include_str!("plate.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (number, point) = (cells[0] as usize, [cells[2], cells[3]]);
        if number == marks.len() {
            let what = format!("mark {number}");
            marks.push(Mark { points: vec![point], red: cells[1] == 1.0, what, corners: Vec::new() });
            continue;
        }
        let points = &mut marks[number].points;
        let from = points[points.len() - 1];
        let count = ((point[0] - from[0]).hypot(point[1] - from[1]) / 0.02).ceil().max(1.0) as u32;
        let on = |k: u32| [0, 1].map(|axis| from[axis] + (point[axis] - from[axis]) * f64::from(k) / f64::from(count));
        points.extend((1..=count).map(on));
    }
    let words = ["sim", "plate.dxf", "--machine", "m.toml", "--tick-us", "100", "--trace", "t.csv", "--strict"];
    let (said, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("on a layer that is off or frozen is not marked (1)"), "{said}");
    differs(&marks, &rows(&folder.path().join("t.csv"))).unwrap();
    // Units, and layers by name and by number.
    let inches = include_str!("plate.dxf").replace("$INSUNITS\n 70\n4\n", "$INSUNITS\n 70\n1\n");
    fs::write(folder.path().join("inch.dxf"), inches).unwrap();
    let only = ["--layer", "layer=CUT,colour=1,power=5,speed=900", "--layer", "skip=true", "--at", "-300,-300"];
    let (said, code) = beamtick(folder.path(), &[&["check", "inch.dxf", "--machine", "m.toml"][..], &only].concat());
    assert!(code == 2 && said.contains("goes to Y 886.4"), "{said}");
    let (said, code) = beamtick(folder.path(), &[&["check", "plate.dxf", "--machine", "m.toml"][..], &only].concat());
    assert!(code == 0 && said.contains("X -300.000 to -200.000, Y -300.000 to -240.000"), "{said}");
}

#[test]
fn what_is_wrong_in_a_dxf_has_line_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let with = |entities: &str| format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
    let line = "0\nLINE\n62\n1\n10\n0\n20\n0\n11\n5\n21\n5\n";
    let blocks = |inner: &str, entities: &str| format!("0\nSECTION\n2\nBLOCKS\n{inner}0\nENDSEC\n{}", with(entities));
    let bomb: String = (0..12)
        .map(|k| {
            let inner =
                if k == 0 { line.to_owned() } else { format!("0\nINSERT\n2\nB{}\n10\n0\n20\n0\n", k - 1).repeat(10) };
            format!("0\nBLOCK\n2\nB{k}\n10\n0\n20\n0\n{inner}0\nENDBLK\n8\n0\n")
        })
        .collect();
    let spline = |degree: u32, knots: &str| {
        let points: String = (0..4).map(|k| format!("10\n{k}\n20\n{}\n", k * k)).collect();
        let knots: String = knots.split(' ').map(|knot| format!("40\n{knot}\n")).collect();
        with(&format!("0\nSPLINE\n62\n1\n71\n{degree}\n{knots}{points}"))
    };
    let cases: Vec<(String, &str)> = vec![
        (with(line).replace("EOF\n", ""), "this is no whole DXF: the file ends before its EOF"),
        (with(line)[..60].to_owned(), "d.dxf:18: this is no whole DXF: the file ends among its entities"),
        (String::new(), "d.dxf:1: this is no whole DXF"),
        ("G1 X5\nG1 X6\n".to_owned(), "d.dxf:1: this is no DXF: `G1 X5` is no group code"),
        (with(&line.replace("11\n5", "11\nnan")), "d.dxf:14: `nan`, of group 11, is no number within"),
        (with(&line.replace("11\n5", "11\n1e300")), "`1e300`, of group 11, is no number within"),
        (with(&line.replace("11\n5\n", "")), "a LINE has no group 11"),
        (with(&line.replace("62\n1", "62\n3")), "takes colour 3 (#00ff00) on layer `0` (1 shapes)"),
        (with(&line.replace("11\n5", "11\n5000")), "the LINE of line 6 goes to X 5000.000 mm"),
        (with("0\nCIRCLE\n62\n1\n10\n0\n20\n0\n40\n0\n"), "d.dxf:6: the radius of a CIRCLE is 0; it is above 0"),
        (with("0\nTEXT\n1\nhello\n"), "d.dxf:6: TEXT is not supported: make lines"),
        (with("0\nHATCH\n"), "HATCH is not supported"),
        (with("0\nARC\n10\n0\n20\n0\n40\n5\n50\n0\n51\n9\n210\n1\n220\n0\n230\n0\n"), "is not in the plane of X and Y"),
        (with("0\nINSERT\n2\nNONE\n10\n0\n20\n0\n"), "the block `NONE` does not exist, or is in itself"),
        (blocks(&bomb, "0\nINSERT\n2\nB11\n10\n0\n20\n0\n"), "blocks make more than 1000000 shapes"),
        (spline(5, "0 0"), "a SPLINE has the degree 5; 1 to 3"),
        (
            with("0\nSPLINE\n62\n1\n71\n3\n74\n2\n11\n0\n21\n0\n11\n5\n21\n5\n"),
            "d.dxf:6: a SPLINE has fit points only, which is not supported: explode it, or save it with control points",
        ),
        (spline(3, "0 0 0 0 1 1 1"), "a SPLINE has 7 knots for 4 control points; they are 8"),
        (spline(3, "0 0 0 0 1 1 0 1"), "and never fall"),
        (with(""), "there is nothing to mark"),
        ("AutoCAD Binary DXF\r\n\u{1a}\u{0}".to_owned(), "it is a binary DXF; save it as ASCII"),
        ("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n3\n0\nENDSEC\n".to_owned() + &with(line), "its unit ($INSUNITS 3)"),
    ];
    for (dxf, says) in &cases {
        fs::write(folder.path().join("d.dxf"), dxf).unwrap();
        let begin = std::time::Instant::now();
        let (said, code) = beamtick(folder.path(), &["sim", "d.dxf", "--machine", "m.toml", "--trace", "t.csv"]);
        let shown: String = dxf.chars().take(200).collect();
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{shown}: {code} {said}");
        assert!(said.len() < 900 && begin.elapsed().as_secs() < 20, "{shown}: {} bytes", said.len());
        assert!(!folder.path().join("t.csv").exists(), "{shown}");
    }
}
