//! What is refused, and that nothing moves then.
use super::*;

#[test]
fn what_is_wrong_has_a_reason_and_nothing_moves() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let stroke = "stroke=\"#f00\"";
    let entities: String =
        (1..10).map(|k| format!("<!ENTITY a{k} \"{}\">", format!("&a{};", k - 1).repeat(10))).collect();
    let uses: String =
        (1..10).map(|k| format!("<g id=\"u{k}\">{}</g>", format!("<use href=\"#u{}\"/>", k - 1).repeat(10))).collect();
    let whole = page(LINE);
    let cases: Vec<(String, &str)> = vec![
        (whole[..whole.len() - 4].to_owned(), "d.svg:3: this is no whole SVG"),
        (whole[..120].to_owned(), "d.svg:2: this is no whole SVG"),
        (String::new(), "d.svg:1: this is no whole SVG"),
        ("G1 X5\n".to_owned(), "d.svg:1: this is no whole SVG"),
        ("<html/>".to_owned(), "d.svg:1: its root is <html>, not <svg>"),
        (page(&format!("<path d=\"M0 0LNaN 1\" {stroke}/>")), "d.svg:2: <path>: d is `M0 0LNaN 1`: segment 2"),
        (page(&format!("<path d=\"M0 0L1e30 1\" {stroke}/>")), "segment 2: 1e30 is beyond ±10000000"),
        (page(&format!("<path d=\"M0 0L5 5L\" {stroke}/>")), "d.svg:2: <path>: d is `M0 0L5 5L`: segment 3"),
        (page(&format!("<circle r=\"NaN\" {stroke}/>")), "d.svg:2: <circle>: r is `NaN`"),
        (page(&format!("<circle r=\"-5\" {stroke}/>")), "d.svg:2: <circle>: r is `-5`: it is below 0"),
        (page(&format!("<rect width=\"inf\" height=\"5\" {stroke}/>")), "d.svg:2: <rect>: width is `inf`"),
        (page(&format!("<polygon points=\"0,0 5,5 5\" {stroke}/>")), "points is `0,0 5,5 5`: a number is missing"),
        (page(&format!("<g transform=\"rotate(x)\">{LINE}</g>")), "d.svg:2: <g>: transform is `rotate(x)`"),
        (
            page(&format!("<g transform=\"scale(1e6)\"><g transform=\"scale(1e6)\">{LINE}</g></g>")),
            "the path of line 2 goes farther than 1000000 mm",
        ),
        (
            page(&format!("<rect width=\"500\" height=\"5\" id=\"big\" {stroke}/>")),
            "`big` goes to X 500.000 mm in the machine",
        ),
        (
            page(&format!("<circle cx=\"399\" r=\"3\" {stroke}/><path d=\"M0-301V5\" {stroke}/>")),
            "the path of line 2 goes to Y 401.000 mm in the machine; the travel is -400 to 400 mm, --at moves a drawing; 2 shapes leave \
             the travel; the drawing covers X 0.000 to 402.000, Y 95.000 to 401.000 mm",
        ),
        (
            page("<text x=\"5\" y=\"5\">Beam</text>"),
            "d.svg:2: the text cannot be marked: convert text to paths in the drawing program",
        ),
        (
            page(&format!("{LINE}\n<g><text id=\"title\"><tspan>Beam</tspan></text></g>")),
            "d.svg:3: the text `title` cannot be marked: convert text to paths in the drawing program",
        ),
        (page("<image href=\"a.png\" width=\"5\" height=\"5\"/>"), "d.svg:2: an image cannot be marked"),
        (
            page(&format!("{LINE}<path d=\"M0 0L1 1\" {stroke} stroke-dasharray=\"1 two\"/>")),
            "d.svg:2: <path>: stroke-dasharray is `1 two`: ",
        ),
        (
            page(&format!("<g style=\"stroke-dasharray: 1,-2\">{LINE}</g>")),
            "d.svg:2: <g>: stroke-dasharray is `1,-2`: a length is below 0",
        ),
        (
            page(&format!("<path d=\"M0 0L1 1\" {stroke} stroke-dashoffset=\"x\"/>")),
            "d.svg:2: <path>: stroke-dashoffset is `x`: ",
        ),
        (
            page(&format!("{LINE}\n<path d=\"M0 0H50\" {stroke} stroke-dasharray=\"0.0001\"/>")),
            "with the dashes of the path of line 3 there are more than 100000: make them longer",
        ),
        (
            page(&format!("<path id=\"p\" pathLength=\"10\" d=\"M0 0H50\" {stroke} stroke-dasharray=\"1\"/>")),
            "the dashes of `p` have other units by its pathLength, which is not supported: remove that",
        ),
        (
            page(&format!(
                "<defs><path id=\"p\" pathLength=\"10\" d=\"M0 0H50\" {stroke}/></defs><use href=\"#p\" stroke-dasharray=\"1\"/>"
            )),
            "the dashes of a shape in the use of line 2 have other units by its pathLength",
        ),
        (
            page(&format!(
                "<g stroke-dasharray=\"1\"><path style=\"vector-effect:non-scaling-stroke\" d=\"M0 0H50\" {stroke}/></g>"
            )),
            "the dashes of the path of line 2 have other units by its vector-effect",
        ),
        (
            page(
                "<linearGradient id=\"g\"><stop/><stop offset=\"1\" stop-color=\"red\"/></linearGradient><path d=\"M0 0L1 1\" stroke=\"url(#g)\"/>",
            ),
            "the stroke of the path of line 2 is a gradient",
        ),
        (
            page(&format!(
                "<clipPath id=\"c\"><circle r=\"1\"/></clipPath><g id=\"cut\" clip-path=\"url(#c)\">{LINE}</g>"
            )),
            "the group `cut` is cut by a clip path",
        ),
        (page("<path d=\"M0 0L1 1\" stroke=\"#0f0\"/>"), "no layer takes #00ff00 (1 shapes)"),
        (
            page("<rect width=\"5\" height=\"5\"/>"),
            "there is nothing to mark: no shape has a stroke; shapes with a fill and no stroke are not marked (1)",
        ),
        (
            format!("<!DOCTYPE svg [<!ENTITY a0 \"xxxxxxxxxx\">{entities}]>\n{}", page("<g id=\"&a9;\"/>")),
            "entity reference loop",
        ),
        (
            page(&format!("<defs><g id=\"u0\">{LINE}</g>{uses}</defs><use href=\"#u9\"/>")),
            "more than 1,000,000 elements",
        ),
        (page(&format!("{}{LINE}{}", "<g>".repeat(10_000), "</g>".repeat(10_000))), "nested more than 1,000 deep"),
        (
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"0\" height=\"5\"/>".to_owned(),
            "d.svg:1: its width, height or viewBox",
        ),
    ];
    for (svg, says) in &cases {
        let begin = std::time::Instant::now();
        fs::write(folder.path().join("d.svg"), svg).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv"]);
        let shown: String = svg.chars().take(200).collect();
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{shown}: {code} {said}");
        assert!(said.len() < 800 && begin.elapsed().as_secs() < 20, "{shown}: {} bytes", said.len());
        assert!(!folder.path().join("t.csv").exists() && !folder.path().join("t.csv.partial").exists(), "{shown}");
    }
    for (bytes, says) in [
        (&[0xff, 0xd8, 0xff, 0xe0, 0, 1, 2][..], "d.svg:1: this is not UTF-8 text"),
        (&[0x1f, 0x8b, 8, 0], "it is compressed (.svgz)"),
        (&[0; 4096], "d.svg:1: this is no whole SVG"),
    ] {
        fs::write(folder.path().join("d.svg"), bytes).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.svg", "--machine", "m.toml"]);
        assert!(code == 2 && said.contains(says), "{said}");
    }
    fs::create_dir(folder.path().join("folder.svg")).unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    fs::write(folder.path().join("bare.toml"), machine("")).unwrap();
    fs::write(folder.path().join("d.svg"), page(LINE)).unwrap();
    for (words, says) in [
        (&["sim", "folder.svg", "--machine", "m.toml"][..], "folder.svg: the drawing cannot be read: Is a directory"),
        (&["sim", "folder", "--machine", "m.toml"], "folder: the job file cannot be read: Is a directory"),
        (&["sim", "d.svg"], "d.svg: G-code and drawings need --machine FILE"),
        (&["sim", "d.svg", "--machine", "bare.toml"], "the machine file has no [[layers]]"),
        (&["sim", "d.svg", "--machine", "m.toml", "--pass-stops"], "--pass-stops is for G-code"),
        (&["sim", "d.svg", "--machine", "m.toml", "--at", "5"], "it is X,Y in mm"),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "power=90,speed=5"],
            "power is 90; it is 0 to 80 % (laser.power)",
        ),
        (&["sim", "d.svg", "--machine", "m.toml", "--layer", "powr=9,speed=5"], "the nearest known key is `power`"),
        (&["sim", "d.svg", "--machine", "m.toml", "--layer", "power"], "`power` is not KEY=VALUE"),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "speed=5"],
            "--layer speed=5: it has no power; a layer needs power and speed",
        ),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "colour=#f0,power=1,speed=5"],
            "colour is \"#f0\"; a colour is",
        ),
        (&["import", "d.svg", "--machine", "m.toml", "-o", "d.svg"], "would overwrite a file"),
    ] {
        let (said, code) = beamtick(folder.path(), words);
        assert!(code == 2 && said.contains(says), "{words:?}: {said}");
    }
}

/// What the reader of SVG does not know, or applies otherwise than SVG says, has line and reason.
#[test]
fn what_would_be_passed_over_in_silence_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let symbol = "<symbol id=\"q\" viewBox=\"0 0 10 10\"><path d=\"M4 4L6 6\" stroke=\"#f00\"/></symbol>";
    let shown = |size: &str| format!("{symbol}\n<use href=\"#q\" {size}/>");
    let styled = |style: &str| format!("{LINE}\n<style>\n{style}</style>");
    let shape = |text: &str| format!("{LINE}\n<{text} stroke=\"#f00\"/>");
    let whole = "d.svg:3: <use> of the symbol `q` has a width in %, which is not supported: give it in px or mm";
    for (inside, says) in [
        (shown("width=\"50%\" height=\"10\""), whole),
        (shown("width=\"10\" height=\"50%\""), "has a height in %"),
        (shown("x=\"10%\" width=\"10\" height=\"10\""), "has an x in %"),
        (
            shape("rect width=\"5\" height=\"5\" transform=\"rotate(9)\" transform-box=\"fill-box\""),
            "d.svg:3: <rect>: transform-box is `fill-box`, which is not supported",
        ),
        (shape("path d=\"M0 0H5\" style=\"transform-box: fill-box\""), "d.svg:3: <path>: transform-box is `fill-box`"),
        (styled("path { transform-box: fill-box }"), "d.svg:3: <style>: transform-box is `fill-box`"),
        (styled("path:not(.x) { stroke: blue }"), "d.svg:3: <style>: the selector `path:not(.x)` is not supported"),
        (styled(".a ~ path, .b { stroke: blue }"), "the selector `.a ~ path, .b` is not supported"),
        (styled("g :nth-child(2) { stroke: blue }"), "the selector `g :nth-child(2)` is not supported"),
        (styled(".a { stroke: blue } .b stroke: red }"), "`.b stroke: red }` is no whole rule"),
        (styled(".a { stroke: blue } /* .b {}"), "`/* .b {}` is no whole rule"),
        (
            styled("@media screen { path { stroke: blue } }"),
            "d.svg:3: <style>: `@media` is not supported: remove it, or write its rules without it",
        ),
        (styled("@charset \"a;b\"; path { stroke: blue }"), "d.svg:3: <style>: a part of it is not understood"),
        (styled("@import url(a.css); path { stroke: blue }"), "d.svg:3: <style>: `@import` is not supported"),
        (styled(".a { --b: 1; stroke: blue }"), "d.svg:3: <style>: `--b: 1` cannot be read: remove it"),
        (styled(".a { g { stroke: blue } }"), "d.svg:3: <style>: `g { stroke: blue }` cannot be read"),
        (styled(".a { fill: none } <!-- --> path { stroke: blue }"), "d.svg:3: <style>: an XML comment cuts it"),
        (
            shape("path d=\"M0 0H5\" style=\"font:2px/3 a;stroke:blue\""),
            "d.svg:3: <path>: `font:2px/3 a` in its style cannot be read: remove it",
        ),
        (
            format!("{LINE}\n<style media=\"print\">path {{ stroke: blue }}</style>"),
            "d.svg:3: <style>: media is `print`",
        ),
        (
            shape("rect width=\"5\" height=\"5\" style=\"x: 9px\""),
            "d.svg:3: <rect>: x in a style is not supported: make it an attribute",
        ),
        (shape("rect height=\"5\" style=\"width:9px\""), "d.svg:3: <rect>: width in a style is not supported"),
        (shape("path style=\"d:path('M0 0H5')\""), "d.svg:3: <path>: d in a style is not supported"),
        (shape("circle style=\"r: 9px\""), "d.svg:3: <circle>: r in a style is not supported"),
        (styled("circle { r: 9px }"), "d.svg:3: <style>: r in a style sheet is not supported: make it an attribute"),
        (shape("path d=\"M0 0L1e300 1\""), "segment 2: 1e300 is beyond ±10000000"),
        (shown("width=\"0\" height=\"9\""), "d.svg:3: <use> of the symbol `q` has a width of 0 or less"),
        (shown("width=\"9\" height=\"-5\""), "has a height of 0 or less"),
        (
            format!("{symbol}\n<symbol id=\"o\"><use href=\"#q\" width=\"9\"/></symbol><use href=\"#o\"/>"),
            "d.svg:3: <use> of the symbol `q` in another symbol has no height of its own",
        ),
        (
            format!("<symbol id=\"q\" height=\"9\">{LINE}</symbol>\n<use href=\"#q\" width=\"9\"/>"),
            "d.svg:3: <use> of the symbol `q` has the height of that, which is not supported",
        ),
        (
            format!("<symbol id=\"q\" transform=\"scale(2)\">{LINE}</symbol>\n<use href=\"#q\"/>"),
            "d.svg:3: <use> of the symbol `q` has a transform in that, which is not supported",
        ),
        (
            "<symbol id=\"q\" viewBox=\"0 0 9 9\">\n<path d=\"M0 0H5\"/><circle r=\"25%\"/></symbol><use href=\"#q\"/>"
                .to_owned(),
            "d.svg:3: <circle>: r in % within a symbol is not supported",
        ),
        (styled("rect { width: 30px }"), "d.svg:3: <style>: width in a style sheet is not supported"),
        (styled(".a { STROKE: blue }"), "d.svg:3: <style>: `STROKE` has capitals, and is not read"),
        (shape("path d=\"M0 0H5\" style=\"Stroke:blue\""), "d.svg:3: <path>: `Stroke` has capitals"),
        (shape("path d=\"M0 0H5\" style=\"rotate:45deg\""), "d.svg:3: <path>: rotate in a style is not supported"),
        (styled(".a { all: unset }"), "d.svg:3: <style>: all in a style is not supported"),
        (
            styled(".a { vector-effect: non-scaling-stroke; stroke-dasharray: 2 }"),
            "d.svg:3: <style>: vector-effect in a style sheet, with dashes, is not supported",
        ),
    ] {
        let svg = page(&inside);
        fs::write(folder.path().join("d.svg"), &svg).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv"]);
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{svg}: {code} {said}");
        assert!(!folder.path().join("t.csv").exists(), "{svg}");
    }
    // What changes no marks, or is applied as SVG says.
    for inside in [
        shape("path d=\"M0 0\" style=\"stroke:blue;aspect-ratio:1/2\" transform-box=\"view-box\""),
        styled("@charset \"a\"; @namespace url(b); @font-face { src: url(c); } @-webkit-keyframes d { to { r: 0 } }"),
        styled(
            "/* { */ path:hover { stroke: blue } g > .a + [b=\"},\"], #c:active /* ; */ { stroke: blue;; fill: none }",
        ),
        format!("{LINE}<style media=\"all\">.a {{ stroke: blue }}</style><style media=\" Screen, tv\"/>"),
        format!("{LINE}<style type=\"text/x\">@media {{</style><style><![CDATA[.a {{ stroke: blue }}]]></style>"),
        styled("svg { width: 100%; height: auto; vector-effect: none }"),
        styled("svg { font: 12px/1.4 sans-serif } .a { vector-effect: non-scaling-stroke; rotate: none }"),
        shape("path d=\"M0 0\" transform=\"none\""),
        // As Illustrator writes what other programs do not read.
        format!(
            "<switch><foreignObject requiredExtensions=\"a\" width=\"1\" height=\"1\"><a/></foreignObject><g>{LINE}</g></switch>"
        ),
        shape("path d=\"none\""),
        shape("path d=\"\n none \" id=\"n\""),
    ] {
        let (said, code) = check(folder.path(), &page(&inside));
        assert!(code == 0 && said.contains("marks of 1.414 mm"), "{inside}: {said}");
    }
    let (said, code) = check(folder.path(), &page(&shown("width=\"100%\" height=\"100%\"")));
    assert!(code == 0 && said.contains("X 40.000 to 60.000, Y 40.000 to 60.000"), "{said}");
}
