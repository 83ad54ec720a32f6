//! A table for people: printed as Markdown, or put into a page.

use comfy_table::{CellAlignment, ContentArrangement, presets};
use std::fmt;

/// Columns of words, then columns of numbers.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Table {
    /// Titles of the columns.
    pub header: Vec<String>,
    /// How many of the columns hold words: these are set to the left, numbers to the right.
    pub words: usize,
    /// A cell a column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Without rows.
    pub fn new<T: Into<String>>(words: usize, header: impl IntoIterator<Item = T>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), words, rows: vec![] }
    }

    /// Adds a row, a cell a column.
    pub fn push(&mut self, row: impl IntoIterator<Item = String>) {
        self.rows.push(row.into_iter().collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = comfy_table::Table::new();
        table.load_style(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(&self.header).add_rows(&self.rows);
        for column in table.column_iter_mut().skip(self.words) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        f.write_str(&table.trim_fmt())
    }
}
