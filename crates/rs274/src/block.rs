//! One line as data: words, parameter assignments, or one control-flow word.
//!
//! Order in a line is free but for `/`, `N` and `O`, which come first (NISTIR 6556, section 3.3).

use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::expression::Expression;
use super::lex::Cursor;

/// A letter and its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    pub letter: char,
    pub value: Expression,
    pub column: u32,
    pub text: String,
    /// Whether it is a number in digits without a decimal point.
    pub lacks_point: bool,
}

/// `#target = value`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Assignment {
    pub target: Target,
    pub value: Expression,
    pub column: u32,
    pub text: String,
}

/// What is assigned to.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Target {
    Numbered(Expression),
    Named(String),
}

/// What follows an O-word's label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keyword {
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// A label alone: a subroutine's start for `M98`.
    Label,
}

const KEYWORDS: [(&str, Keyword); 15] = [
    ("sub", Keyword::Sub),
    ("endsub", Keyword::EndSub),
    ("return", Keyword::Return),
    ("call", Keyword::Call),
    ("if", Keyword::If),
    ("elseif", Keyword::ElseIf),
    ("else", Keyword::Else),
    ("endif", Keyword::EndIf),
    ("while", Keyword::While),
    ("endwhile", Keyword::EndWhile),
    ("do", Keyword::Do),
    ("repeat", Keyword::Repeat),
    ("endrepeat", Keyword::EndRepeat),
    ("break", Keyword::Break),
    ("continue", Keyword::Continue),
];

/// The label of an O-word.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Label {
    /// A number in digits, or a name in `<>`; on LinuxCNC `<7>` is 7.
    Fixed(String),
    /// A number computed when the line is executed: only for `call`.
    Computed(Expression),
}

/// A control-flow line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Flow {
    pub label: Label,
    pub keyword: Keyword,
    pub arguments: Vec<Expression>,
    pub column: u32,
    pub text: String,
}

/// A control-flow word of Fanuc's macro language.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Jump {
    /// GOTO and the number of a line.
    Goto(Expression),
    /// DO and the loop's number; with a condition, WHILE.
    Do(u32),
    /// END and the loop's number.
    End(u32),
}

/// A line.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    pub deletable: bool,
    /// The line's number: N.
    pub sequence: Option<u32>,
    /// What must hold for the line to be executed: IF and WHILE of Fanuc's macro language.
    pub condition: Option<Expression>,
    pub jump: Option<Jump>,
    /// Whether anything in it asks for a parameter.
    pub reads_parameters: bool,
    pub flow: Option<Flow>,
    pub words: Vec<Word>,
    pub assignments: Vec<Assignment>,
    /// What the reader should know of the line.
    pub notes: Vec<&'static str>,
}

impl Block {
    /// Whether there is nothing in it to execute.
    pub fn is_empty(&self) -> bool {
        self.flow.is_none() && !self.has_more()
    }

    /// Whether it says more than its O-word.
    pub fn has_more(&self) -> bool {
        !self.words.is_empty() || !self.assignments.is_empty() || self.condition.is_some() || self.jump.is_some()
    }

    /// Reads a line.
    pub fn parse(line: &str, dialect: Dialect) -> Result<Self, Fault> {
        let block = Self::read(line, dialect)?;
        if dialect.is_fanuc_like() && line.contains(';') {
            refuse_second_block(line, dialect)?;
        }
        Ok(block)
    }

    fn read(line: &str, dialect: Dialect) -> Result<Self, Fault> {
        let mut cursor = Cursor::new(line, dialect)?;
        let like_fanuc = dialect.is_fanuc_like();
        let reads_parameters = line.contains('#');
        let mut block = Self { reads_parameters, ..Self::default() };
        block.read_slash(&mut cursor)?;
        if dialect == Dialect::Grbl && cursor.peek().is_some_and(|first| matches!(first, '$' | '?' | '!' | '~')) {
            block.notes.push(setting(&mut cursor)?);
            return Ok(block);
        }
        if like_fanuc && is_told_elsewhere(&mut cursor) {
            return Ok(block);
        }
        if cursor.accept('n') {
            block.sequence = line_number(cursor.number()?);
            cursor.skip_comments()?;
            if like_fanuc {
                block.read_slash(&mut cursor)?;
            }
        }
        if cursor.peek() == Some('o') || (like_fanuc && cursor.peek() == Some(':')) {
            block.flow = Some(flow(&mut cursor)?);
            cursor.skip_comments()?;
            let only_label = block.flow.as_ref().is_some_and(|flow| flow.keyword == Keyword::Label);
            match cursor.peek() {
                None => return Ok(block),
                Some(_) if like_fanuc && only_label => {}
                Some(_) => return Err(cursor.fault_here(Cause::UnexpectedCharacter)),
            }
        }
        loop {
            cursor.skip_comments()?;
            match cursor.peek() {
                None => {
                    if cursor.nested_comment {
                        block.notes.push(
                            "a comment inside a comment is taken for a part of it; Grbl ends comments at the first `)`",
                        );
                    }
                    return Ok(block);
                }
                // Haas's controls need no IF.
                Some('[') if dialect == Dialect::Haas && !block.has_more() => {
                    block.condition = Some(Expression::bracketed(&mut cursor)?);
                }
                Some('#') => block.assignments.push(assignment(&mut cursor)?),
                Some(',') if like_fanuc => block.words.push(corner_word(&mut cursor)?),
                Some(letter) if letter.is_ascii_alphabetic() || is_sign(letter) => {
                    if like_fanuc {
                        if macro_word(&mut cursor, &mut block)? {
                            continue;
                        }
                    } else {
                        refuse_macro_word(&mut cursor)?;
                    }
                    block.words.push(word(&mut cursor, letter)?);
                }
                Some(_) => return Err(cursor.fault_here(Cause::UnexpectedCharacter)),
            }
        }
    }

    /// Reads `/`, on Fanuc's and Haas's controls with the switch's number.
    fn read_slash(&mut self, cursor: &mut Cursor) -> Result<(), Fault> {
        if cursor.accept('/') {
            self.deletable = true;
            if cursor.dialect.is_fanuc_like() {
                cursor.accept_digit();
            }
        }
        cursor.skip_comments()
    }
}

/// Fanuc's and Haas's controls end the block at `;`, where others begin a comment. A fault where words stand behind it.
fn refuse_second_block(line: &str, dialect: Dialect) -> Result<(), Fault> {
    let mut in_comment = false;
    let ends_block = |character| {
        in_comment = match character {
            '(' => true,
            ')' => false,
            _ => in_comment,
        };
        character == ';' && !in_comment
    };
    let mut column = 1;
    for (at, part) in line.split(ends_block).enumerate() {
        if at > 0 && Block::read(part, dialect).is_ok_and(|block| !block.is_empty()) {
            return Err(Fault::new(column, part.trim(), Cause::SecondBlock));
        }
        column += part.chars().count() as u32 + 1;
    }
    Ok(())
}

/// The number of N as an integer; `None` where it is none, as in N10.5.
fn line_number(number: f64) -> Option<u32> {
    (number.fract() == 0.0 && number <= f64::from(u32::MAX)).then_some(number as u32)
}

/// A program's name in `<>`, and lines that print: nothing to execute.
fn is_told_elsewhere(cursor: &mut Cursor) -> bool {
    cursor.peek() == Some('<')
        || ["dprnt[", "bprnt[", "popen", "pclos"].into_iter().any(|word| cursor.accept_word(word))
}

/// A line for Grbl itself: settings, questions and holds move nothing; homing, jogging and sleep do, and are refused.
fn setting(cursor: &mut Cursor) -> Result<&'static str, Fault> {
    let column = cursor.column();
    let command = cursor.rest().to_ascii_uppercase();
    let moves = ["$H", "$J", "$SLP", "$RST"].iter().any(|word| command.replace(' ', "").starts_with(word));
    if moves {
        return Err(Fault::new(
            column,
            command,
            Cause::NotAllowed("a command to the control that moves its axes or its zero"),
        ));
    }
    Ok("a line for the control itself (`$`, `?`, `!`, `~`) is skipped")
}

/// Reads a control-flow word of the macro language, if one comes next. All but GOTO may be cut down to two letters, as the controls allow: `GO` is
/// more often `G0` with a letter for its digit.
fn macro_word(cursor: &mut Cursor, block: &mut Block) -> Result<bool, Fault> {
    let column = cursor.column();
    let loop_number = |cursor: &mut Cursor| {
        let number = line_number(cursor.number()?).filter(|&number| number > 0);
        number.ok_or_else(|| {
            Fault::new(column, cursor.text_from(column), Cause::Range("the loop's number", "a whole number above 0"))
        })
    };
    if cursor.accept_word("goto") {
        block.jump = Some(Jump::Goto(Expression::value(cursor)?));
    } else if ["end", "en"].into_iter().any(|word| cursor.accept_word(word)) {
        block.jump = Some(Jump::End(loop_number(cursor)?));
    } else if cursor.accept_word("do") {
        block.jump = Some(Jump::Do(loop_number(cursor)?));
    } else if ["then", "th"].into_iter().any(|word| cursor.accept_word(word)) {
        if block.condition.is_none() {
            return Err(Fault::new(column, cursor.text_from(column), Cause::Flow("has no IF before it")));
        }
    } else if ["if[", "while[", "wh["].into_iter().any(|word| cursor.looks_at_word(word)) {
        cursor.letters();
        block.condition = Some(Expression::bracketed(cursor)?);
    } else {
        return Ok(false);
    }
    Ok(true)
}

/// `,R` and `,C`: the radius and the length of a corner.
fn corner_word(cursor: &mut Cursor) -> Result<Word, Fault> {
    let column = cursor.column();
    cursor.expect(',', "`,`")?;
    let letter = match cursor.next() {
        Some('r') => 'R',
        Some('c') => 'C',
        _ => return Err(Fault::new(column, cursor.text_from(column), Cause::Expected("R or C behind `,`"))),
    };
    let value = Expression::value(cursor)?;
    let text = cursor.text_from(column);
    let lacks_point = value.is_literal() && !text.contains('.');
    Ok(Word { letter, value, column, text, lacks_point })
}

/// Control flow of Fanuc's macro language, which would else be words with unknown functions for values. `IF` needs its bracket:
/// `IFIX[1.5]` is a word.
fn refuse_macro_word(cursor: &mut Cursor) -> Result<(), Fault> {
    let column = cursor.column();
    if ["if[", "goto", "while", "end"].into_iter().any(|word| cursor.accept_word(word)) {
        return Err(Fault::new(column, cursor.text_from(column), Cause::MacroWord));
    }
    Ok(())
}

/// `@` and `^`: radius and angle instead of X and Y (LinuxCNC, "Polar Coordinates"); `$`: which spindle.
const fn is_sign(letter: char) -> bool {
    matches!(letter, '@' | '^' | '$')
}

fn word(cursor: &mut Cursor, letter: char) -> Result<Word, Fault> {
    let column = cursor.column();
    cursor.next();
    if matches!(letter, 'n' | 'o') {
        return Err(Fault::new(
            column,
            letter.to_ascii_uppercase(),
            Cause::Expected("N and O at the start of the line"),
        ));
    }
    let is_known = matches!(letter, 'a'..='m' | 'p'..='z') || is_sign(letter) && !cursor.dialect.is_fanuc_like();
    if !is_known {
        return Err(Fault::new(column, letter.to_ascii_uppercase(), Cause::UnknownLetter));
    }
    let value = Expression::value(cursor)?;
    let text = cursor.text_from(column);
    let lacks_point = value.is_literal() && !text.contains('.');
    Ok(Word { letter, value, column, text, lacks_point })
}

fn assignment(cursor: &mut Cursor) -> Result<Assignment, Fault> {
    let column = cursor.column();
    cursor.expect('#', "`#`")?;
    let target = if cursor.peek() == Some('<') {
        Target::Named(cursor.name()?)
    } else {
        Target::Numbered(Expression::value(cursor)?)
    };
    cursor.expect('=', "`=`")?;
    let value = if cursor.dialect.is_fanuc_like() { Expression::open(cursor)? } else { Expression::value(cursor)? };
    Ok(Assignment { target, value, column, text: cursor.text_from(column) })
}

fn flow(cursor: &mut Cursor) -> Result<Flow, Fault> {
    let column = cursor.column();
    if !cursor.accept(':') {
        cursor.expect('o', "`O`")?;
    }
    let label = match cursor.peek() {
        Some('<') => {
            let name = cursor.name()?;
            let is_number = !cursor.dialect.is_fanuc_like() && name.bytes().all(|digit| digit.is_ascii_digit());
            Label::Fixed(if is_number { name } else { format!("<{name}>") })
        }
        Some('#' | '[') => Label::Computed(Expression::value(cursor)?),
        _ => Label::Fixed(format!("{}", cursor.number()?)),
    };
    let keyword_column = cursor.column();
    // Where O only names a program, words may follow it.
    let is_macro_word = ["if[", "while[", "wh[", "goto", "do"].iter().any(|word| cursor.looks_at_word(word));
    let only_names = cursor.dialect.is_fanuc_like() && (is_macro_word || !cursor.looks_at_keyword());
    let name = if only_names { String::new() } else { cursor.letters() };
    let keyword = match KEYWORDS.iter().find(|entry| entry.0 == name) {
        Some(entry) => entry.1,
        None if name.is_empty() => Keyword::Label,
        None => return Err(Fault::new(keyword_column, name, Cause::Flow("unknown control-flow word"))),
    };
    if matches!(label, Label::Computed(_)) && keyword != Keyword::Call {
        return Err(Fault::new(column, cursor.text_from(column), Cause::Flow("only `call` may compute its label")));
    }
    let text = cursor.text_from(column);
    let mut arguments = Vec::new();
    cursor.skip_comments()?;
    while cursor.peek() == Some('[') {
        arguments.push(Expression::bracketed(cursor)?);
        cursor.skip_comments()?;
    }
    let wanted = match keyword {
        Keyword::Call => 0..=super::parameters::LOCAL_PARAMETERS,
        Keyword::If | Keyword::ElseIf | Keyword::While | Keyword::Repeat => 1..=1,
        Keyword::Return | Keyword::EndSub => 0..=1,
        _ => 0..=0,
    };
    if !wanted.contains(&arguments.len()) {
        return Err(Fault::new(column, text, Cause::Flow("wrong number of values in brackets")));
    }
    Ok(Flow { label, keyword, arguments, column, text })
}
