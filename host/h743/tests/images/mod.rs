//! The images that variables name (`cargo xtask check-all` sets them).

/// The image that a variable names, if it does.
pub fn named(variable: &str) -> Option<Vec<u8>> {
    let Some(path) = std::env::var_os(variable) else {
        println!("skipped: {variable} names no image");
        return None;
    };
    Some(std::fs::read(path).unwrap())
}

/// The name of the board that BEAMTICK_H743_IMAGE is for, and whether that is the image for an
/// external DAC: then BEAMTICK_H743_DAC_IMAGE names the same file.
pub fn reference() -> (&'static [u8], bool) {
    let [image, for_dac] = ["BEAMTICK_H743_IMAGE", "BEAMTICK_H743_DAC_IMAGE"].map(std::env::var_os);
    if image.is_some() && image == for_dac { (b"h743zi2-dac8563", true) } else { (b"nucleo-h743zi2", false) }
}
