//! Text from files that only shows itself, whatever it holds.

/// Where Unicode has pictures of the control characters.
const PICTURES: u32 = 0x2400;
/// The control character that has its picture elsewhere.
const DELETE: char = '\u{7f}';
const PICTURE_OF_DELETE: char = '\u{2421}';

/// A character in place of one that acts on a terminal, or on the direction of the text that follows it; others as they
/// are, line breaks and tabs among them.
pub fn visible(c: char) -> char {
    match c {
        '\n' | '\t' => c,
        DELETE => PICTURE_OF_DELETE,
        c if c.is_ascii_control() => char::from_u32(PICTURES + u32::from(c)).unwrap_or(c),
        c if c.is_control() => char::REPLACEMENT_CHARACTER,
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
            char::REPLACEMENT_CHARACTER
        }
        c => c,
    }
}
