//! As much of XML as VTK files use: elements, attributes, text; comments and
//! processing instructions are passed over, entities are left as they stand.

/// A piece of an XML text.
#[derive(Debug, PartialEq)]
pub(super) enum Piece<'a> {
    /// `<name key="value">`, also for `<name/>`, which a `Close` follows.
    Open(&'a str, Vec<(&'a str, &'a str)>),
    /// `</name>`.
    Close(&'a str),
    /// What stands between elements, unless blank.
    Text(&'a str),
}

/// The value of `key` among `attributes`.
pub(super) fn attribute<'a>(attributes: &[(&'a str, &'a str)], key: &str) -> Option<&'a str> {
    attributes.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
}

/// Takes an XML text apart, piece by piece.
pub(super) struct Reader<'a> {
    text: &'a str,
    at: usize,
    /// The name of an element of the form `<name/>` that is still to be closed.
    to_close: Option<&'a str>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: 0, to_close: None }
    }

    /// Line of the place reached, counted from 1.
    pub(super) fn line(&self) -> usize {
        1 + self.text.as_bytes()[..self.at].iter().filter(|byte| **byte == b'\n').count()
    }

    /// The next piece, `None` at the end of the text.
    pub(super) fn next(&mut self) -> Result<Option<Piece<'a>>, String> {
        if let Some(name) = self.to_close.take() {
            return Ok(Some(Piece::Close(name)));
        }
        loop {
            let rest = &self.text[self.at..];
            let Some(inner) = rest.strip_prefix('<') else {
                let end = rest.find('<').unwrap_or(rest.len());
                self.at += end;
                let text = rest[..end].trim();
                match (text.is_empty(), end == rest.len()) {
                    (true, true) => return Ok(None),
                    (true, false) => continue,
                    (false, _) => return Ok(Some(Piece::Text(text))),
                }
            };
            if inner.starts_with("!--") {
                self.skip_past(rest, "-->")?;
            } else if inner.starts_with('?') {
                self.skip_past(rest, "?>")?;
            } else if inner.starts_with('!') {
                self.skip_past(rest, ">")?;
            } else {
                return self.element(rest).map(Some);
            }
        }
    }

    fn skip_past(&mut self, rest: &str, end: &str) -> Result<(), String> {
        let place = rest.find(end).ok_or_else(|| format!("`{end}` is missing"))?;
        self.at += place + end.len();
        Ok(())
    }

    fn element(&mut self, rest: &'a str) -> Result<Piece<'a>, String> {
        let end = end_of_tag(rest).ok_or("`>` is missing")?;
        self.at += end + 1;
        let inside = &rest[1..end];
        if let Some(name) = inside.strip_prefix('/') {
            return Ok(Piece::Close(name.trim()));
        }
        let (inside, empty) = match inside.strip_suffix('/') {
            Some(inside) => (inside, true),
            None => (inside, false),
        };
        let (name, attributes) =
            inside.split_once(|c: char| c.is_whitespace()).unwrap_or((inside, ""));
        if empty {
            self.to_close = Some(name);
        }
        Ok(Piece::Open(name, parse_attributes(attributes)?))
    }
}

/// Place of the `>` that ends the tag at the start of `text`; one inside quotes
/// does not. `None` if another tag begins first.
fn end_of_tag(text: &str) -> Option<usize> {
    let mut quote = None;
    for (place, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(place),
            (None, b'<') if place > 0 => return None,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

fn parse_attributes(text: &str) -> Result<Vec<(&str, &str)>, String> {
    let mut attributes = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (key, after) = rest.split_once('=').ok_or("an attribute has no value")?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| *c == '"' || *c == '\'');
        let (value, tail) = quote
            .and_then(|quote| after[1..].split_once(quote))
            .ok_or("the value of an attribute is not in quotes")?;
        attributes.push((key.trim(), value));
        rest = tail.trim_start();
    }
    Ok(attributes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_a_text_apart() {
        let text = "<?xml version=\"1.0\"?>\n<!-- < --><A k='1 > 0' l=\"\"> one \n <B/></A>\n";
        let mut reader = Reader::new(text);
        let mut pieces = Vec::new();
        while let Some(piece) = reader.next().expect("well formed") {
            pieces.push(piece);
        }
        assert_eq!(
            pieces,
            vec![
                Piece::Open("A", vec![("k", "1 > 0"), ("l", "")]),
                Piece::Text("one"),
                Piece::Open("B", vec![]),
                Piece::Close("B"),
                Piece::Close("A"),
            ]
        );
        assert_eq!(reader.line(), 4);
    }

    #[test]
    fn broken_text_is_an_error() {
        for text in ["<a", "<a <b>", "<!-- a", "<a b>", "<a b=c>", "<a b='c>"] {
            let mut reader = Reader::new(text);
            assert!(reader.next().is_err(), "{text}");
        }
    }
}
