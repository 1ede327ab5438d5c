//! A walk through JSON text by the places of its keys and values.

/// A place in valid JSON text. Its methods return `None` at the end of the text, or where
/// something else stands than they look for.
pub(crate) struct Cursor<'a> {
    json: &'a [u8],
    pub(crate) at: usize,
    /// Where the key or the element begins that was entered last.
    pub(crate) begin: usize,
}

impl<'a> Cursor<'a> {
    /// At the outermost value of the text.
    pub(crate) fn new(json: &'a str) -> Self {
        let mut cursor = Self {
            json: json.as_bytes(),
            at: 0,
            begin: 0,
        };
        cursor.skip_space();
        cursor.begin = cursor.at;
        cursor
    }

    /// From an object to its value of that key.
    pub(crate) fn enter_key(&mut self, key: &str) -> Option<()> {
        self.expect(b'{')?;
        while self.peek()? == b'"' {
            let start = self.at + 1;
            self.skip_string()?;
            let found = self.json.get(start..self.at - 1)?;
            self.skip_space();
            self.expect(b':')?;
            if found == key.as_bytes() {
                self.begin = start - 1;
                return Some(());
            }
            self.skip_value()?;
            self.expect(b',')?;
        }
        None
    }

    /// From a list to its element of that index.
    pub(crate) fn enter_index(&mut self, index: usize) -> Option<()> {
        self.expect(b'[')?;
        for _ in 0..index {
            self.skip_value()?;
            self.expect(b',')?;
        }
        self.begin = self.at;
        (self.peek()? != b']').then_some(())
    }

    /// To the separator behind the value.
    pub(crate) fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            match self.peek()? {
                b'"' => {
                    self.skip_string()?;
                    continue;
                }
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth > 0 => depth -= 1,
                b',' | b'}' | b']' if depth == 0 => return Some(()),
                _ => {}
            }
            self.at += 1;
        }
    }

    fn skip_string(&mut self) -> Option<()> {
        self.at += 1;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        Some(())
    }

    fn expect(&mut self, byte: u8) -> Option<()> {
        (self.peek()? == byte).then(|| self.at += 1)?;
        self.skip_space();
        Some(())
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    fn peek(&self) -> Option<u8> {
        self.json.get(self.at).copied()
    }
}
