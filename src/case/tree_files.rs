//! Lines of a tree as they are read: from one file with all of them, or from tables of the case and a file for each.

use super::centre_line::{Apart, from_the_beginning, line_of_branch, lines_of_tree};
use super::tree::{TreeKeys, TreeLine};
use super::{LengthUnit, Mistake};
use fsi_numerics::twelve_digits;

impl TreeKeys {
    /// Reads the files of the lines, if there are some: each line then leads from the beginning to an end.
    ///
    /// # Errors
    /// What is wrong; there are no lines then.
    pub(super) fn read_lines(&mut self) -> Result<(), Vec<Mistake>> {
        let given = self.line.take();
        let found = match (&self.lines, given) {
            (Some(_), Some(_)) => {
                let reason = "the case has [[tree.line]] as well: leave out one of the two";
                Err(vec![("tree.lines".into(), reason.into())])
            }
            (Some(_), None) => self.lines_of_file().map_err(|mistake| vec![mistake]),
            (None, Some(lines)) => self.lines_of_case(lines),
            (None, None) => {
                let reason =
                    "expected its centre-lines next to it: tree.lines, or tables [[tree.line]]";
                Err(vec![("tree".into(), reason.into())])
            }
        };
        self.line = Some(found?);
        self.change_lines()
            .map_err(|(key, reason)| vec![(key.into(), reason)])
    }

    /// The unit of files, which `key` names.
    fn unit_of(&self, key: &str) -> Result<LengthUnit, Mistake> {
        self.unit.ok_or_else(|| {
            let words: Vec<_> = LengthUnit::WORDS.iter().map(|(word, _)| *word).collect();
            let words = words.join("\", \"");
            let what = "expected its unit of length next to it";
            (
                key.into(),
                format!("{what}: tree.unit = one of \"{words}\""),
            )
        })
    }

    fn lines_of_file(&self) -> Result<Vec<TreeLine>, Mistake> {
        let key = "tree.lines";
        let size = self.unit_of(key)?.metres();
        let path = self.lines.clone().unwrap_or_default();
        let lines = lines_of_tree(&path);
        let lines = lines.map_err(|e| (key.into(), format!("{}: {e}", path.display())))?;
        let scaled = lines.into_iter().map(|(points, radii)| TreeLine {
            points: points.into_iter().map(|x| x.map(|c| c * size)).collect(),
            radii: radii.into_iter().map(|r| r * size).collect(),
            ..TreeLine::default()
        });
        Ok(scaled.collect())
    }

    fn lines_of_case(&self, mut given: Vec<TreeLine>) -> Result<Vec<TreeLine>, Vec<Mistake>> {
        let key = |i: usize, name: &str| format!("tree.line[{i}].{name}");
        let mut mistakes = Vec::new();
        if let Some(i) = given.iter().position(|line| line.file.is_some()) {
            let unit = self
                .unit_of(&key(i, "file"))
                .map_err(|mistake| vec![mistake])?;
            for (i, line) in given.iter_mut().enumerate() {
                let read = line.read_file(unit);
                mistakes.extend(read.err().map(|reason| (key(i, "file"), reason)));
            }
        }
        let mut parents = Vec::new();
        for i in 0..given.len() {
            let parent = parent(&given, i);
            mistakes.extend(parent.clone().err().map(|reason| (key(i, "from"), reason)));
            parents.push(parent.ok().flatten());
        }
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        // What is wrong with their points is said when they are checked.
        if given.iter().any(|line| line.curve().is_none()) {
            return Ok(given);
        }
        let lines: Vec<_> = (given.iter())
            .map(|line| (line.points.clone(), line.radii.clone()))
            .collect();
        let whole = from_the_beginning(&lines, &parents).map_err(|apart| {
            let named = parents[apart.line].map_or("", |_| ".from");
            let key = format!("tree.line[{}]{named}", apart.line);
            vec![(key, told(&given, &apart))]
        })?;
        let named = whole.into_iter().map(|(number, (points, radii))| TreeLine {
            name: given[number].name.clone(),
            points,
            radii,
            ..TreeLine::default()
        });
        Ok(named.collect())
    }
}

impl TreeLine {
    /// Reads the file of its points, if it has one.
    fn read_file(&mut self, unit: LengthUnit) -> Result<(), String> {
        let Some(path) = &self.file else {
            return Ok(());
        };
        if !self.points.is_empty() || !self.radii.is_empty() {
            return Err(
                "the table has points_m or radii_m as well: leave out one of the two".into(),
            );
        }
        let line = line_of_branch(path, unit);
        (self.points, self.radii) = line.map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(())
    }

    /// What it is called in a message.
    fn called(&self, number: usize) -> String {
        let by_number = || format!("{} of [[tree.line]]", number + 1);
        self.name
            .as_ref()
            .map_or_else(by_number, |name| format!("\"{name}\""))
    }
}

/// The line that a line begins on, if it says so.
fn parent(lines: &[TreeLine], number: usize) -> Result<Option<usize>, String> {
    let find = |number: usize| -> Result<Option<usize>, String> {
        let Some(from) = &lines[number].from else {
            return Ok(None);
        };
        let mut found = lines
            .iter()
            .enumerate()
            .filter(|(_, line)| line.name.as_ref() == Some(from));
        match (found.next(), found.next()) {
            (Some((parent, _)), None) => Ok(Some(parent)),
            (Some(_), Some(_)) => Err(format!("two lines are called {from:?}: rename one of them")),
            (None, _) => {
                let names = lines.iter().filter_map(|line| line.name.as_deref());
                let names: Vec<&str> = names.collect();
                let names = names.join("\", \"");
                Err(format!("no line is called {from:?}; there is \"{names}\""))
            }
        }
    };
    let parent = find(number)?;
    let mut way = vec![number];
    let mut at = parent;
    while let Some(next) = at.filter(|_| way.len() <= lines.len()) {
        if next == number && way.iter().all(|line| number <= *line) {
            let way: Vec<String> = (way.iter().chain([&number]))
                .map(|line| lines[*line].called(*line))
                .collect();
            let way = way.join(" on ");
            return Err(format!(
                "line {way}: lines that begin on each other in a circle have no inlet"
            ));
        }
        way.push(next);
        at = find(next).ok().flatten();
    }
    Ok(parent)
}

fn told(lines: &[TreeLine], apart: &Apart) -> String {
    let [line, nearest] = [apart.line, apart.nearest].map(|i| lines[i].called(i));
    let path = lines[apart.line].file.as_ref();
    let path = path.map_or(String::new(), |path| format!("{}: ", path.display()));
    let [x, y, z] = lines[apart.line].points[0].map(twelve_digits);
    let millimetres = |length: f64| format!("{:.3} mm", 1e3 * length);
    format!(
        "{path}line {line} begins at ({x}, {y}, {z}) m, {} from line {nearest}, whose radius there is {}: expected a first point \
         within that radius of the line that it begins on",
        millimetres(apart.distance),
        millimetres(apart.radius)
    )
}
