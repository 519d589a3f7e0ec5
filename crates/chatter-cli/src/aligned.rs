//! Text in columns.

/// Which side of a column its cells stand at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Rows of cells below each other, indented, with two spaces between columns. Columns without a side stand left.
pub fn aligned(rows: &[Vec<String>], sides: &[Side]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let wide = |text: &String| text.chars().count();
    let widths: Vec<usize> = (0..columns)
        .map(|column| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells.map(wide).max().unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, cell) in row.iter().enumerate() {
            let space = " ".repeat(widths[column] - wide(cell));
            line += "  ";
            match sides.get(column) {
                Some(Side::Right) => {
                    line += &space;
                    line += cell;
                }
                _ => {
                    line += cell;
                    line += &space;
                }
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows = [["n", "fold"], ["10", "-"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(aligned(&rows, &[Side::Right]), "   n  fold\n  10  -\n");
    }
}
