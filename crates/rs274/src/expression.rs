//! Values: numbers, parameters, functions and bracketed expressions, compiled to reverse Polish code.
//!
//! Operators and precedence as LinuxCNC documents them (G-code overview, "Expressions"): `**`; `* / MOD`; `+ -`;
//! `EQ NE GT GE LT LE`; `AND OR XOR`; equal ones from left to right. Angles are in degrees. `EQ` and `NE` compare within
//! [`EQUALITY_TOLERANCE`].
//!
//! On Fanuc's and Haas's controls `AND`, `OR` and `XOR` are of bits; `AND` binds as `*`, `OR` and `XOR` bind as `+`; `MOD` has the dividend's sign; and
//! `ROUND` in the value of a word rounds to the least increment of the word's address. Fanuc's `ATAN` of two arguments is from 0 to 360 degrees
//! and its `ASIN` from 270 to 90, which is what its parameter 6004#0 (NAT) says at 0 (operator's manual, "Custom Macro", "Arithmetic and Logic
//! Operation").

use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::lex::Cursor;
use super::parameters::Parameters;

/// Deepest nesting of brackets, functions and `#`: bounds the parser's recursion.
pub const MAX_EXPRESSION_DEPTH: usize = 64;

/// Two values this close are equal for `EQ` and `NE`, in whatever unit they have (LinuxCNC's `TOLERANCE_EQUAL`).
pub const EQUALITY_TOLERANCE: f64 = 1e-4;

/// One step of reverse Polish code.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Number(f64),
    /// Replaces a number by the value of the numbered parameter.
    Parameter,
    Named(String),
    /// Whether there is a parameter of this name.
    Exists(String),
    /// Replaces a number by whether there is a parameter of this number.
    ExistsNumbered,
    Negate,
    Function(Function),
    /// Adds a turn to an angle below zero.
    FullTurn,
    Binary(Binary),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Abs,
    Acos,
    Asin,
    /// Of two arguments: `ATAN[y]/[x]`, in Fanuc's macros also `ATAN[y, x]` and `ATAN[tangent]`.
    Atan,
    ArcTangent,
    /// Of two arguments: `POW[base, exponent]`.
    Raise,
    /// Towards zero, and away from it: Fanuc's FIX and FUP.
    Truncate,
    Expand,
    Cos,
    Exp,
    Fix,
    Fup,
    Ln,
    Round,
    Sin,
    Sqrt,
    Tan,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Binary {
    Power,
    Times,
    Divide,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    And,
    Or,
    Xor,
    /// Of bits.
    BitAnd,
    BitOr,
    BitXor,
    /// With the dividend's sign.
    Remainder,
}

const FUNCTIONS: [(&str, Function); 13] = [
    ("abs", Function::Abs),
    ("acos", Function::Acos),
    ("asin", Function::Asin),
    ("atan", Function::Atan),
    ("cos", Function::Cos),
    ("exp", Function::Exp),
    ("fix", Function::Fix),
    ("fup", Function::Fup),
    ("ln", Function::Ln),
    ("round", Function::Round),
    ("sin", Function::Sin),
    ("sqrt", Function::Sqrt),
    ("tan", Function::Tan),
];

/// Operators with their binding strength; `**` before `*`.
const OPERATORS: [(&str, Binary, u8); 15] = [
    ("**", Binary::Power, 5),
    ("*", Binary::Times, 4),
    ("/", Binary::Divide, 4),
    ("mod", Binary::Modulo, 4),
    ("+", Binary::Plus, 3),
    ("-", Binary::Minus, 3),
    ("eq", Binary::Equal, 2),
    ("ne", Binary::NotEqual, 2),
    ("gt", Binary::Greater, 2),
    ("ge", Binary::GreaterEqual, 2),
    ("lt", Binary::Less, 2),
    ("le", Binary::LessEqual, 2),
    ("and", Binary::And, 1),
    ("or", Binary::Or, 1),
    ("xor", Binary::Xor, 1),
];

/// What Fanuc's and Haas's controls have instead of LinuxCNC's operators of the same name.
const FANUC_OPERATORS: [(&str, Binary, u8); 4] =
    [("mod", Binary::Remainder, 4), ("and", Binary::BitAnd, 4), ("or", Binary::BitOr, 3), ("xor", Binary::BitXor, 3)];

/// A compiled value: its steps with the column each stands at.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Expression {
    steps: Vec<(Step, u32)>,
}

impl Expression {
    /// Reads one value: a number, `#...`, `[...]` or a function, with signs before it.
    pub fn value(cursor: &mut Cursor) -> Result<Self, Fault> {
        let mut steps = Vec::new();
        value(cursor, &mut steps, 0)?;
        Ok(Self { steps })
    }

    /// Reads `[...]`.
    pub fn bracketed(cursor: &mut Cursor) -> Result<Self, Fault> {
        let mut steps = Vec::new();
        bracketed(cursor, &mut steps, 0)?;
        Ok(Self { steps })
    }

    /// Reads a value, or several with operators between them and no brackets around.
    pub fn open(cursor: &mut Cursor) -> Result<Self, Fault> {
        let mut steps = Vec::new();
        operators(cursor, &mut steps, 0, false)?;
        Ok(Self { steps })
    }

    /// Whether it is a number in digits.
    pub fn is_literal(&self) -> bool {
        matches!(self.steps.as_slice(), [(Step::Number(_), _)] | [(Step::Number(_), _), (Step::Negate, _)])
    }

    /// The whole number it is in digits, if it is one.
    pub fn literal(&self) -> Option<f64> {
        match self.steps.as_slice() {
            [(Step::Number(number), _)] if number.fract() == 0.0 => Some(*number),
            _ => None,
        }
    }

    /// Whether there is a ROUND in it.
    pub fn rounds(&self) -> bool {
        self.steps.iter().any(|(step, _)| *step == Step::Function(Function::Round))
    }

    /// Whether the expression contains a comparison.
    pub fn compares(&self) -> bool {
        self.steps.iter().any(|(step, _)| matches!(step, Step::Binary(operator) if operator.compares()))
    }

    /// Its value as a number; a vacant variable counts as zero.
    pub fn number(&self, parameters: &Parameters) -> Result<f64, Fault> {
        self.evaluate(parameters).map(or_zero)
    }

    /// What it comes to. The result is finite, or vacant (not a number) where it is a vacant variable of a dialect that has such.
    pub fn evaluate(&self, parameters: &Parameters) -> Result<f64, Fault> {
        self.evaluate_to(parameters, 1.0)
    }

    /// The same where ROUND rounds to `1 / per_unit`.
    pub fn evaluate_to(&self, parameters: &Parameters, per_unit: f64) -> Result<f64, Fault> {
        let mut stack: Vec<f64> = Vec::new();
        for (step, column) in &self.steps {
            let fault = |text: &str, cause| Fault::new(*column, text, cause);
            let result = match step {
                Step::Number(number) => *number,
                Step::Named(name) => parameters.named(name).map_err(|cause| fault(&format!("#<{name}>"), cause))?,
                Step::Exists(name) => f64::from(parameters.named(name) != Err(Cause::UnknownParameter)),
                Step::ExistsNumbered => f64::from(parameters.numbered(pop(&mut stack)) != Err(Cause::UnknownParameter)),
                Step::Parameter => {
                    let number = pop(&mut stack);
                    parameters.numbered(number).map_err(|cause| fault(&format!("#{number}"), cause))?
                }
                Step::Negate => -pop(&mut stack),
                Step::Function(function @ (Function::Atan | Function::Raise)) => {
                    let second = or_zero(pop(&mut stack));
                    let first = or_zero(pop(&mut stack));
                    if *function == Function::Atan {
                        first.atan2(second).to_degrees()
                    } else {
                        Binary::Power.apply(first, second).map_err(|why| fault("pow", Cause::Domain(why)))?
                    }
                }
                Step::Function(Function::Round) => (or_zero(pop(&mut stack)) * per_unit).round() / per_unit,
                Step::Function(function) => function
                    .apply(or_zero(pop(&mut stack)))
                    .map_err(|why| fault(function.name(), Cause::Domain(why)))?,
                Step::FullTurn => {
                    let angle = pop(&mut stack);
                    if angle < 0.0 {
                        parameters.has_full_turn.set(true);
                        angle + 360.0
                    } else {
                        angle
                    }
                }
                Step::Binary(operator) => {
                    let right = pop(&mut stack);
                    operator.apply(pop(&mut stack), right).map_err(|why| fault(operator.name(), Cause::Domain(why)))?
                }
            };
            let may_be_vacant = matches!(step, Step::Parameter | Step::Negate);
            if !(result.is_finite() || (may_be_vacant && result.is_nan())) {
                return Err(fault("", Cause::Domain("the result is not a finite number")));
            }
            stack.push(result);
        }
        Ok(pop(&mut stack))
    }
}

/// A vacant value is zero to whatever computes with it.
fn or_zero(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().expect("the parser emits every operand before its operator")
}

impl Function {
    fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|entry| entry.1 == self).map_or("", |entry| entry.0)
    }

    fn apply(self, x: f64) -> Result<f64, &'static str> {
        Ok(match self {
            Self::Abs => x.abs(),
            Self::Acos if x.abs() > 1.0 => return Err("argument outside [-1, 1]"),
            Self::Asin if x.abs() > 1.0 => return Err("argument outside [-1, 1]"),
            Self::Acos => x.acos().to_degrees(),
            Self::Asin => x.asin().to_degrees(),
            Self::Atan | Self::ArcTangent => x.atan().to_degrees(),
            Self::Raise => x,
            Self::Truncate => x.trunc(),
            Self::Expand => x.abs().ceil().copysign(x),
            Self::Cos => x.to_radians().cos(),
            Self::Exp => x.exp(),
            Self::Fix => x.floor(),
            Self::Fup => x.ceil(),
            Self::Ln if x <= 0.0 => return Err("logarithm of a number that is not positive"),
            Self::Ln => x.ln(),
            Self::Round => x.round(),
            Self::Sin => x.to_radians().sin(),
            Self::Sqrt if x < 0.0 => return Err("square root of a negative number"),
            Self::Sqrt => x.sqrt(),
            Self::Tan => x.to_radians().tan(),
        })
    }
}

impl Binary {
    fn name(self) -> &'static str {
        OPERATORS.iter().chain(&FANUC_OPERATORS).find(|entry| entry.1 == self).map_or("", |entry| entry.0)
    }

    const fn compares(self) -> bool {
        matches!(self, Self::Equal | Self::NotEqual | Self::Greater | Self::GreaterEqual | Self::Less | Self::LessEqual)
    }

    const fn is_of_bits(self) -> bool {
        matches!(self, Self::BitAnd | Self::BitOr | Self::BitXor)
    }

    fn apply(self, a: f64, b: f64) -> Result<f64, &'static str> {
        // A vacant value equals a vacant one alone.
        let equal =
            if a.is_nan() || b.is_nan() { a.is_nan() && b.is_nan() } else { (a - b).abs() < EQUALITY_TOLERANCE };
        let (a, b) = (or_zero(a), or_zero(b));
        Ok(match self {
            Self::Power if a < 0.0 && b.fract() != 0.0 => return Err("negative number to a power that is not whole"),
            Self::Power => a.powf(b),
            Self::Times => a * b,
            Self::Divide if b == 0.0 => return Err("division by zero"),
            Self::Divide => a / b,
            Self::Modulo if b == 0.0 => return Err("modulo by zero"),
            Self::Modulo => a.rem_euclid(b.abs()),
            Self::Plus => a + b,
            Self::Minus => a - b,
            Self::Equal => f64::from(equal),
            Self::NotEqual => f64::from(!equal),
            Self::Greater => f64::from(a > b),
            Self::GreaterEqual => f64::from(a >= b),
            Self::Less => f64::from(a < b),
            Self::LessEqual => f64::from(a <= b),
            Self::And => f64::from(a != 0.0 && b != 0.0),
            Self::Or => f64::from(a != 0.0 || b != 0.0),
            Self::Xor => f64::from((a != 0.0) != (b != 0.0)),
            Self::Remainder => {
                let (a, b) = (whole(a)?, whole(b)?);
                (a.checked_rem(b).ok_or("modulo by zero")?) as f64
            }
            Self::BitAnd => (whole(a)? & whole(b)?) as f64,
            Self::BitOr => (whole(a)? | whole(b)?) as f64,
            Self::BitXor => (whole(a)? ^ whole(b)?) as f64,
        })
    }
}

/// An operand of Fanuc's `AND`, `OR`, `XOR` and `MOD`. What these make of fractions depends on the control.
fn whole(x: f64) -> Result<i64, &'static str> {
    let rounded = x.round();
    let is_whole = (x - rounded).abs() < EQUALITY_TOLERANCE && rounded.abs() <= f64::from(u32::MAX);
    is_whole.then_some(rounded as i64).ok_or("AND, OR, XOR and MOD of a number that is not whole")
}

type Steps = Vec<(Step, u32)>;

fn check_depth(cursor: &mut Cursor, depth: usize) -> Result<(), Fault> {
    if depth < MAX_EXPRESSION_DEPTH {
        return Ok(());
    }
    Err(cursor.fault_here(Cause::Limit { limit: MAX_EXPRESSION_DEPTH, what: "expressions inside one another" }))
}

fn value(cursor: &mut Cursor, steps: &mut Steps, depth: usize) -> Result<(), Fault> {
    check_depth(cursor, depth)?;
    let column = cursor.column();
    match cursor.peek() {
        Some('[') => bracketed(cursor, steps, depth),
        Some('#') => parameter(cursor, steps, depth),
        Some('+') => {
            cursor.next();
            value(cursor, steps, depth + 1)
        }
        Some('-') => {
            cursor.next();
            value(cursor, steps, depth + 1)?;
            steps.push((Step::Negate, column));
            Ok(())
        }
        Some(letter) if letter.is_ascii_alphabetic() => function(cursor, steps, depth),
        _ => {
            steps.push((Step::Number(cursor.number()?), column));
            Ok(())
        }
    }
}

fn parameter(cursor: &mut Cursor, steps: &mut Steps, depth: usize) -> Result<(), Fault> {
    let column = cursor.column();
    cursor.expect('#', "`#`")?;
    if cursor.peek() == Some('<') {
        steps.push((Step::Named(cursor.name()?), column));
    } else {
        value(cursor, steps, depth + 1)?;
        steps.push((Step::Parameter, column));
    }
    Ok(())
}

fn function(cursor: &mut Cursor, steps: &mut Steps, depth: usize) -> Result<(), Fault> {
    let column = cursor.column();
    let name = cursor.letters();
    if name == "exists" {
        cursor.expect('[', "`[`")?;
        cursor.expect('#', "`#` and a parameter's number or name")?;
        if cursor.peek() == Some('<') {
            steps.push((Step::Exists(cursor.name()?), column));
        } else {
            value(cursor, steps, depth + 1)?;
            steps.push((Step::ExistsNumbered, column));
        }
        return cursor.expect(']', "`]`");
    }
    let like_fanuc = cursor.dialect.is_fanuc_like();
    let known = FUNCTIONS.iter().find(|entry| entry.0 == name).map(|entry| entry.1);
    let function = match (known, name.as_str()) {
        (Some(Function::Fix), _) if like_fanuc => Function::Truncate,
        (Some(Function::Fup), _) if like_fanuc => Function::Expand,
        (Some(Function::Atan), _) if like_fanuc => return arc_tangent(cursor, steps, depth, column),
        (Some(function), _) => function,
        (None, "rnd") if like_fanuc => Function::Round,
        (None, "sqr") if like_fanuc => Function::Sqrt,
        (None, "pow") if like_fanuc => {
            two_arguments(cursor, steps, depth)?;
            steps.push((Step::Function(Function::Raise), column));
            return Ok(());
        }
        (None, _) => return Err(Fault::new(column, name, Cause::UnknownFunction)),
    };
    bracketed(cursor, steps, depth + 1)?;
    if function == Function::Atan {
        cursor.expect('/', "`/` between the arguments of ATAN")?;
        bracketed(cursor, steps, depth + 1)?;
    }
    steps.push((Step::Function(function), column));
    if function == Function::Asin && cursor.dialect == Dialect::Fanuc {
        steps.push((Step::FullTurn, column));
    }
    Ok(())
}

/// Fanuc's ATAN of one or two arguments.
fn arc_tangent(cursor: &mut Cursor, steps: &mut Steps, depth: usize, column: u32) -> Result<(), Fault> {
    check_depth(cursor, depth)?;
    cursor.expect('[', "`[`")?;
    operators(cursor, steps, depth + 1, true)?;
    let two = if cursor.accept(',') {
        operators(cursor, steps, depth + 1, true)?;
        cursor.expect(']', "`]`")?;
        true
    } else {
        cursor.expect(']', "`,` or `]`")?;
        let two = cursor.looks_at_word("/[") && cursor.accept('/');
        if two {
            bracketed(cursor, steps, depth + 1)?;
        }
        two
    };
    steps.push((Step::Function(if two { Function::Atan } else { Function::ArcTangent }), column));
    if two && cursor.dialect == Dialect::Fanuc {
        steps.push((Step::FullTurn, column));
    }
    Ok(())
}

/// `[value, value]`.
fn two_arguments(cursor: &mut Cursor, steps: &mut Steps, depth: usize) -> Result<(), Fault> {
    check_depth(cursor, depth)?;
    cursor.expect('[', "`[`")?;
    operators(cursor, steps, depth + 1, true)?;
    cursor.expect(',', "`,`")?;
    operators(cursor, steps, depth + 1, true)?;
    cursor.expect(']', "`]`")
}

/// `[value operator value ...]`.
fn bracketed(cursor: &mut Cursor, steps: &mut Steps, depth: usize) -> Result<(), Fault> {
    check_depth(cursor, depth)?;
    cursor.expect('[', "`[`")?;
    operators(cursor, steps, depth, true)?;
    cursor.expect(']', "operator or `]`")
}

/// `value operator value ...` by operator precedence: a stronger or equal operator on the stack goes out first. Outside brackets a
/// division is one only before a value, and words may follow.
fn operators(cursor: &mut Cursor, steps: &mut Steps, depth: usize, in_brackets: bool) -> Result<(), Fault> {
    check_depth(cursor, depth)?;
    let mut waiting: Vec<(Binary, u8, u32)> = Vec::new();
    let like_fanuc = cursor.dialect.is_fanuc_like();
    let (mut compares, mut has_bits) = (false, false);
    loop {
        value(cursor, steps, depth + 1)?;
        let column = cursor.column();
        if in_brackets && matches!(cursor.peek(), Some(']' | ',')) {
            break;
        }
        let own: &[_] = if like_fanuc { &FANUC_OPERATORS } else { &[] };
        let Some(&(name, operator, strength)) = own.iter().chain(&OPERATORS).find(|entry| cursor.accept_word(entry.0))
        else {
            break;
        };
        (compares, has_bits) = (compares || operator.compares(), has_bits || operator.is_of_bits());
        if compares && has_bits {
            let why = "a comparison beside AND, OR or XOR without brackets of its own";
            return Err(Fault::new(column, name, Cause::NotAllowed(why)));
        }
        while let Some((stronger, _, at)) = waiting.pop_if(|top| top.1 >= strength) {
            steps.push((Step::Binary(stronger), at));
        }
        waiting.push((operator, strength, column));
    }
    steps.extend(waiting.into_iter().rev().map(|(operator, _, at)| (Step::Binary(operator), at)));
    Ok(())
}
