//! What a drawing is told of: places of errors, what is passed over, its size.
use super::*;

/// What the reader of SVG itself complains of without a place, and groups without an id.
#[test]
fn errors_name_the_line_or_the_shape_where_it_can_be_found() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let filter = "<filter id=\"f\"><feGaussianBlur stdDeviation=\"1\"/></filter>";
    let clip =
        "<clipPath id=\"c\"><circle r=\"0.1\"/></clipPath><mask id=\"m\"><rect width=\"9\" height=\"9\"/></mask>";
    let blurred = "<path d=\"M0 0H9\" stroke=\"#f00\" filter=\"url(#f)\"/>";
    let cases: &[(String, &str)] = &[
        (format!("{LINE}\n<g><path d=\"M0 0H9\" stroke=\"foo\"/></g>"), "d.svg:3: <path>: stroke is `foo`"),
        (format!("{LINE}\n<g style=\"stroke: foo\">\n<path d=\"M0 0H9\"/></g>"), "d.svg:3: <g>: stroke is `foo`"),
        (
            format!("<style>.x {{ stroke: foo }}</style>\n<path class=\"x\" d=\"M0 0H9\"/>{LINE}"),
            "d.svg: stroke is `foo`, which cannot be read",
        ),
        (format!("{LINE}\n<g id=\"a\"><use href=\"#a\"/></g>"), "d.svg:3: <use> shows itself"),
        (format!("{LINE}\n<use id=\"u\" href=\"#u\"/>"), "d.svg:3: <use> shows itself"),
        (
            format!("<g id=\"a\">{LINE}\n<use href=\"#b\"/></g><g id=\"b\"><g>\n<use href=\"#a\"/></g></g>"),
            "d.svg:3: <use> shows itself",
        ),
        (
            format!("{LINE}\n<use href=\"other.svg#a\"/>"),
            "d.svg:3: <use> shows `other.svg#a` of another file, which is not read",
        ),
        (format!("{filter}{LINE}\n{blurred}"), "d.svg:3: Filters on zero-sized shapes are not allowed"),
        (
            format!("{filter}{LINE}\n{blurred}\n{blurred}"),
            "d.svg: Filters on zero-sized shapes are not allowed: one of the elements with a filter, of lines 3, 4",
        ),
        (format!("{clip}\n<g clip-path=\"url(#c)\">{LINE}{LINE}</g>"), "the g of line 3 is cut by a clip path"),
        (format!("{clip}\n<g mask=\"url(#m)\">{LINE}{LINE}</g>"), "the g of line 3 has a mask"),
        (format!("{clip}\n<g id=\"own\" mask=\"url(#m)\">{LINE}{LINE}</g>"), "the group `own` has a mask"),
        (
            format!("{clip}\n<path clip-path=\"url(#c)\" d=\"M0 0L1 1\" stroke=\"red\"/>"),
            "the path of line 3 is cut by a clip path",
        ),
        (
            format!("{clip}<defs><g id=\"p\" clip-path=\"url(#c)\">{LINE}</g></defs>\n<use href=\"#p\"/>"),
            "a shape in the use of line 3 is cut by a clip path",
        ),
        (
            format!(
                "<defs>{}</defs>\n<use href=\"#p\"/>",
                LINE.replace("<path", "<path id=\"p\" transform=\"scale(5000)\"")
            ),
            "a shape in the use of line 3 goes to",
        ),
    ];
    for (inside, says) in cases {
        let svg = page(inside);
        fs::write(folder.path().join("d.svg"), &svg).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv"]);
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{svg}: {code} {said}");
        assert!(!said.contains("beamtick:"), "{said}");
        assert!(!folder.path().join("t.csv").exists(), "{svg}");
    }
}

/// What a drawing has and is not marked is said, as what it is.
#[test]
fn what_is_passed_over_is_noted_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let other = "<path d=\"M0 0H5\" stroke=\"#f00\"/>";
    let filled = "shapes with a fill and no stroke";
    for (inside, says, not) in [
        ("<use href=\"#missing\"/>", "the use of line 3 shows `#missing`, which does not exist", "(with"),
        ("<use href=\"#a\"/>\n<use href=\"#b\"/>", "shows `#a`, which does not exist (with it 2", "`#b`"),
        ("<use/>", "the use of line 3 shows nothing: it has no href", filled),
        ("<g display=\"none\"><use href=\"#missing\"/></g><use href=\"#d\"/><defs><g id=\"d\"/></defs>", "", "shows"),
        (
            "<path d=\"M9 9H5V5\" stroke=\"context-stroke\"/>",
            "context-stroke and context-fill are no stroke outside of a marker or a `use` (1)",
            filled,
        ),
        (
            "<g style=\"stroke:context-fill\"><path d=\"M9 9H5V5\" fill=\"none\"/></g>",
            "context-stroke and context-fill are no stroke outside of a marker or a `use` (1)",
            filled,
        ),
        (
            "<defs><path id=\"d\" d=\"M0 9V5\" fill=\"none\" stroke=\"context-stroke\"/></defs><use href=\"#d\"/>",
            "",
            "context",
        ),
        (
            "<path d=\"M0 9V5\" stroke=\"red\" visibility=\"hidden\"/>",
            "what is hidden by its visibility is not marked (1)",
            "transparent",
        ),
        (
            "<path d=\"M0 9V5\" stroke=\"red\" stroke-opacity=\"0\"/>",
            "what is fully transparent is not marked (1)",
            "hidden",
        ),
        (
            "<path d=\"M0 9V5\" stroke=\"url(#nope)\"/>",
            "the stroke of line 3 names `#nope`, which does not exist, and is not marked\n",
            "(with",
        ),
        (
            "<g style=\"stroke:url(#nope)\"><path d=\"M0 9V5\"/></g>\n<path d=\"M0 9V5\" stroke=\"url(#b)\"/>",
            "the stroke of line 3 names `#nope`, which does not exist, and is not marked (with it 2 strokes)",
            "`#b`",
        ),
        (
            "<style>.a { stroke: url(#nope) }</style><path class=\"a\" d=\"M0 9V5\"/>",
            "the stroke of the style sheet of line 3 names `#nope`, which does not exist, and is not marked",
            "(with",
        ),
        ("<path d=\"M0 9V5\" stroke=\"url(#nope) none\"/>", "", "`#nope`"),
        ("<circle cx=\"20\" cy=\"20\" r=\"1e-4\" stroke=\"red\"/>", "shorter than a pulse is not marked (1)", "X 20"),
        (
            "<path d=\"M20 20h1e-5M30 30c1e-4 0 1e-4 1e-4 0 1e-4M40 40h1e-4v1e-4\" stroke=\"red\"/>",
            "what is shorter than a pulse is not marked (3)",
            "X 20",
        ),
    ] {
        let (said, code) = check(folder.path(), &page(&format!("{other}\n{inside}")));
        assert!(code == 0 && said.contains("marks of 5.000 mm"), "{inside}: {said}");
        assert!(said.contains(says) && !said.contains(not), "{inside}: {said}");
    }
    // The colour of a `use` is that of what it shows.
    let shown =
        "<defs><path id=\"d\" d=\"M0 9V5\" stroke=\"context-stroke\"/></defs><use href=\"#d\" stroke=\"#f00\"/>";
    let (said, code) = check(folder.path(), &page(shown));
    assert!(code == 0 && said.contains("marks of 4.000 mm") && !said.contains("context"), "{said}");
}

/// The note about a page's size says what is done.
#[test]
fn the_note_about_the_size_of_a_page_is_true() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (size, marks, note) in [
        ("width=\"100mm\" viewBox=\"0 0 100 50\"", "marks of 10.000 mm, X 0.000 to 10.000, Y 50.000", ""),
        ("height=\"50mm\" viewBox=\"0 0 100 50\"", "marks of 10.000 mm, X 0.000 to 10.000, Y 50.000", ""),
        ("style=\"width:100mm;height:50mm\" viewBox=\"0 0 100 50\"", "marks of 2.646 mm", "26.458 mm wide"),
        ("width=\"192\" viewBox=\"0 0 100 50\"", "marks of 5.080 mm", "50.800 mm wide and 25.400 mm high"),
        ("viewBox=\"0 0 96 48\"", "marks of 2.646 mm", "25.400 mm wide and 12.700 mm high"),
        ("width=\"96\" height=\"48\"", "marks of 2.646 mm", "25.400 mm wide and 12.700 mm high"),
    ] {
        let line = "<path d=\"M0 0H10\" stroke=\"red\"/>";
        let svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {size}>{line}</svg>");
        let (said, code) = check(folder.path(), &svg);
        assert!(code == 0 && said.contains(marks) && said.contains(note), "{size}: {said}");
        assert_eq!(said.contains("a unit"), !note.is_empty(), "{size}: {said}");
    }
}

/// A shape has a pulse where one of its points has: ends, corners, or the side of a circle.
#[test]
fn shapes_without_a_pulse_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let path = |d: &str| page(&format!("<path d=\"{d}\" stroke=\"red\"/>"));
    for (svg, has_one) in [
        (path("M20 20h0.0004"), false),
        (path("M20 20h0.0006"), true),
        (path("M20 20h0.0006h-0.0006"), true),
        (path("M20 20c0.02 0 0.02 0.0001 0 0.0001"), true),
        (path("M20 20c0.0004 0 0.0004 0.0001 0 0.0001"), false),
        (page("<circle cx=\"20\" cy=\"20\" r=\"0.0002\" stroke=\"red\"/>"), false),
        (page("<circle cx=\"20\" cy=\"20\" r=\"0.0008\" stroke=\"red\"/>"), true),
    ] {
        let (said, code) = check(folder.path(), &svg);
        let nothing =
            "d.svg: there is nothing to mark: what is shorter than a pulse is not marked (1); nothing was run";
        assert_eq!((code, said.contains(nothing)), if has_one { (0, false) } else { (2, true) }, "{svg}: {said}");
    }
}

/// A `use` of a symbol lies where the product of all transforms puts it, and is cut by its own size
/// only.
#[test]
fn symbols_are_marked_where_their_use_puts_them() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let line = |d: &str| format!("<path d=\"{d}\" stroke=\"#f00\"/>");
    let diagonal = line("M1 1L9 9");
    let open = format!("<symbol id=\"q\" style=\"overflow:visible\">{diagonal}</symbol>");
    let closed = format!("<symbol id=\"q\">{diagonal}</symbol>");
    let boxed = format!("<symbol id=\"q\" viewBox=\"0 0 10 10\">{}</symbol>", line("M4 4L6 6"));
    let moved = "transform=\"translate(30 40)\"";
    let within = "<g id=\"w\" transform=\"scale(2)\"><use href=\"#q\" transform=\"translate(5 5)\" width=\"10\" height=\"10\"/></g>";
    let nested = format!(
        "<defs>{within}</defs><g transform=\"translate(10 0)\"><use href=\"#w\" transform=\"translate(0 10)\"/></g>"
    );
    let shown = |how: &str| format!("<use href=\"#q\" {how} width=\"10\" height=\"10\"/>");
    for (inside, says) in [
        (shown(moved), "X 31.000 to 39.000, Y 51.000 to 59.000"),
        (shown("style=\"transform:translate(30 40)\""), "X 31.000 to 39.000, Y 51.000 to 59.000"),
        (shown("transform=\"translate(30 40) scale(2)\""), "X 32.000 to 48.000, Y 42.000 to 58.000"),
        (shown("transform=\"translate(50 50) rotate(45)\""), "X 50.000 to 50.000, Y 37.272 to 48.586"),
        (shown("x=\"3\" y=\"4\" transform=\"scale(2)\""), "X 8.000 to 24.000, Y 74.000 to 90.000"),
        (shown("x=\"30\" y=\"40\""), "X 31.000 to 39.000, Y 51.000 to 59.000"),
        (nested, "X 22.000 to 38.000, Y 62.000 to 78.000"),
    ] {
        for symbol in [&open, &closed] {
            let (said, code) = check(folder.path(), &page(&format!("{symbol}{inside}")));
            assert!(code == 0 && said.contains(says) && !said.contains("leaves"), "{symbol}{inside}: {said}");
        }
    }
    for (inside, says) in [
        (shown("transform=\"translate(6 6)\""), "X 10.000 to 12.000, Y 88.000 to 90.000"),
        (shown("transform=\"rotate(90 20 20)\""), "X 34.000 to 36.000, Y 94.000 to 96.000"),
        (shown("transform=\"translate(95 6)\""), "leaves the page"),
        ("<use href=\"#q\" transform=\"translate(6 6)\" width=\"20\" height=\"20\"/>".to_owned(), "X 14.000 to 18.000"),
    ] {
        let (said, code) = check(folder.path(), &page(&format!("{boxed}{inside}")));
        assert!(code == 0 && said.contains(says), "{inside}: {said}");
    }
    // What is cut is still refused, whatever moves it.
    let long = format!("<symbol id=\"q\">{}</symbol>", line("M1 1L19 19"));
    let (said, code) = check(folder.path(), &page(&format!("{long}{}", shown(moved))));
    assert!(code == 2 && said.contains("the use of line 2 is cut by a clip path"), "{said}");
    // A page around turned shapes cuts nothing: their corners would leave it, they do not.
    let clip = "<clipPath id=\"c\"><path d=\"M0.5 0.5H100V100H0.5z\"/></clipPath>";
    let circle = "<g transform=\"rotate(45 50 50)\"><circle cx=\"50\" cy=\"50\" r=\"49\" stroke=\"#f00\"/><path d=\"M50 50z\"/></g>";
    let (said, code) = check(folder.path(), &page(&format!("{clip}<g clip-path=\"url(#c)\">{circle}</g>")));
    assert!(code == 0 && said.contains("X 1.000 to 99.000") && !said.contains("leaves"), "{said}");
}
