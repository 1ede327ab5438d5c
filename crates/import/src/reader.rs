//! Reading the cells of a row.

use crate::Problem;
use crate::clock::{Clock, seconds_of_day};
use crate::columns::{Columns, Names, Source};
use crate::map::{Map, Split};
use crate::stops::Row;
use crate::unit::{Quantity, Unit};

/// What is wrong with a row, and in which column of the export.
pub(crate) struct Fault {
    pub(crate) column: Option<String>,
    pub(crate) problem: Problem,
}

/// Reads rows.
pub(crate) struct Reader<'r> {
    pub(crate) map: &'r Map,
    pub(crate) columns: &'r Columns,
    pub(crate) decimal: char,
    pub(crate) names: Names<'r>,
}

impl Reader<'_> {
    /// What a row says.
    pub(crate) fn row(
        &self,
        line: usize,
        cells: &[String],
        clock: &mut Clock,
    ) -> Result<Row, Fault> {
        let columns = self.columns;
        let (found, needed) = (cells.len(), columns.needed());
        if found < needed {
            let problem = Problem::Short {
                found,
                needed,
                more: 0,
            };
            return Err(Fault {
                column: None,
                problem,
            });
        }
        let splits = columns.splits.iter().zip(&self.map.split);
        let parts = splits.map(|((cell, pattern), Split { pattern: words, .. })| {
            let text = &cells[*cell];
            pattern.split(text).ok_or_else(|| {
                let expected =
                    format!("a text like {words}; or name it in skip_rows, if it is no reading");
                self.fault(&Source::Cell(*cell), text, expected)
            })
        });
        let parts = parts.collect::<Result<_, _>>()?;
        let row = RowText { cells, parts };
        let name = |source: &Option<Source>| -> Option<String> {
            let text = row.text(source.as_ref()?);
            let renamed = self.map.rename.get(text);
            Some(renamed.cloned().unwrap_or_else(|| text.to_owned()))
        };
        let target = name(&columns.target);
        let stops = &self.map.stops;
        let of_path = stops.path.iter().flat_map(|leg| &leg.targets);
        let known = stops.targets.iter().chain(of_path);
        let known: Vec<&str> = known.map(String::as_str).collect();
        if let (Some(source), Some(found)) = (&columns.target, &target)
            && (found.is_empty() || !known.is_empty() && !known.contains(&found.as_str()))
        {
            let expected = match known.is_empty() {
                true => "the name of a target".to_owned(),
                false => format!(
                    "one of {} (targets); other points are skipped with skip_rows = [\"{found}\"] or corrected with rename",
                    known.join(", ")
                ),
            };
            return Err(self.fault(source, row.text(source), expected));
        }
        let axes = columns.axes.iter().map(|axis| {
            let source = axis.source.as_ref();
            source
                .map(|source| self.number(&row, source, Some(axis.unit)))
                .transpose()
        });
        let numbers = columns.numbers.iter().map(|number| {
            if number.optional && row.text(&number.source).is_empty() {
                return Ok(None);
            }
            self.number(&row, &number.source, number.unit).map(Some)
        });
        Ok(Row {
            line,
            station: name(&columns.station),
            run: name(&columns.run),
            target,
            repeat: self.counting(&row, &columns.repeat)?,
            direction: self.direction(&row, &columns.direction)?,
            time_s: self.time(&row, clock)?,
            axes: axes.collect::<Result<_, _>>()?,
            numbers: numbers.collect::<Result<_, _>>()?,
        })
    }

    fn number(&self, row: &RowText<'_>, source: &Source, unit: Option<Unit>) -> Result<f64, Fault> {
        let text = row.text(source);
        // A point is no decimal sign where a comma is; it may part thousands.
        let point = match self.decimal {
            ',' if text.contains('.') => None,
            ',' => Some(text.replace(',', ".")),
            _ => Some(text.to_owned()),
        };
        let number = point
            .and_then(|text| text.parse().ok())
            .filter(|x: &f64| x.is_finite());
        let number = number.ok_or_else(|| self.fault(source, text, self.expected_number(text)))?;
        Ok(unit.map_or(number, |unit| unit.convert(number)))
    }

    fn expected_number(&self, text: &str) -> String {
        let other = if self.decimal == ',' { '.' } else { ',' };
        let is_other = text.contains(other) && text.replace(',', ".").parse::<f64>().is_ok();
        match is_other {
            true => format!(
                "a number with \"{}\" as decimal sign; decimal = \"{other}\" in the map changes it",
                self.decimal
            ),
            false => format!(
                "a number; rows without a reading are skipped with skip_rows = [\"{text}\"]"
            ),
        }
    }

    fn counting(&self, row: &RowText<'_>, source: &Option<Source>) -> Result<Option<u32>, Fault> {
        let counting = |source: &Source| {
            let text = row.text(source);
            let number = text.parse().ok().filter(|&number: &u32| number > 0);
            number.ok_or_else(|| self.fault(source, text, "a whole number from 1".to_owned()))
        };
        source.as_ref().map(counting).transpose()
    }

    fn direction(&self, row: &RowText<'_>, source: &Option<Source>) -> Result<Option<i8>, Fault> {
        let Some(source) = source else {
            return Ok(None);
        };
        match row.text(source) {
            "1" | "+1" | "+" => Ok(Some(1)),
            "-1" | "-" => Ok(Some(-1)),
            other => Err(self.fault(source, other, "1 or -1, the side of approach".to_owned())),
        }
    }

    fn time(&self, row: &RowText<'_>, clock: &mut Clock) -> Result<Option<f64>, Fault> {
        match &self.columns.time {
            None => Ok(None),
            Some((source, unit)) if unit.quantity == Quantity::Clock => {
                let text = row.text(source);
                let of_day_s = seconds_of_day(text);
                let expected = || "a time of day as 10:21:33 (unit \"clock\")".to_owned();
                let of_day_s = of_day_s.ok_or_else(|| self.fault(source, text, expected()))?;
                Ok(Some(clock.since_first_s(of_day_s)))
            }
            Some((source, unit)) => self.number(row, source, Some(*unit)).map(Some),
        }
    }

    fn fault(&self, source: &Source, found: &str, expected: String) -> Fault {
        let cell = match source {
            Source::Cell(cell) => Some(*cell),
            Source::Part { split, .. } => self.columns.splits.get(*split).map(|(cell, _)| *cell),
            Source::Value(_) => None,
        };
        let column = cell.map(|cell| {
            let name = self.names.and_then(|(_, names)| names.get(cell));
            name.cloned().unwrap_or_else(|| (cell + 1).to_string())
        });
        let found = found.to_owned();
        let problem = Problem::Cell {
            found,
            expected,
            more: 0,
        };
        Fault { column, problem }
    }
}

struct RowText<'r> {
    cells: &'r [String],
    parts: Vec<Vec<&'r str>>,
}

impl RowText<'_> {
    fn text<'s>(&'s self, source: &'s Source) -> &'s str {
        match source {
            Source::Cell(cell) => self.cells.get(*cell).map_or("", String::as_str),
            Source::Value(value) => value,
            Source::Part { split, field } => self
                .parts
                .get(*split)
                .and_then(|parts| parts.get(*field))
                .copied()
                .unwrap_or(""),
        }
    }
}
