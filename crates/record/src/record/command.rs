//! Command lines as text: quoted for a POSIX shell, and searched for their options.

/// Joins words to a command line for a POSIX shell.
pub fn command_line<S: AsRef<str>>(words: impl IntoIterator<Item = S>) -> String {
    words.into_iter().map(|word| quoted(word.as_ref())).collect::<Vec<_>>().join(" ")
}

/// The word in single quotes, unless all its characters stand for themselves in a POSIX shell.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_./:=@%+,-".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', ESCAPED))
}

/// A single quote within single quotes: they end, an escaped quote stands outside, and they begin again.
const ESCAPED: &str = r"'\''";

/// Whether a command line has an option, such as `--variant`. What is quoted is no option.
pub fn has_option(command: &str, option: &str) -> bool {
    let outside: String = command.replace(ESCAPED, "").split('\'').step_by(2).collect();
    outside.split_whitespace().any(|word| word.split('=').next() == Some(option))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_not_take_them_as_they_are() {
        for (word, expected) in [
            ("bench-scenes/a_b.c:d=e@f%g+h,i", "bench-scenes/a_b.c:d=e@f%g+h,i"),
            ("a piece.obj", "'a piece.obj'"),
            ("", "''"),
            ("it's", r"'it'\''s'"),
            ("$(rm -r ~)", "'$(rm -r ~)'"),
            ("Fräser", "'Fräser'"),
        ] {
            assert_eq!(quoted(word), expected);
        }
        assert_eq!(command_line(["bvbench", "try", "a b"]), "bvbench try 'a b'");
    }

    #[test]
    fn an_option_is_a_word_of_its_own_outside_quotes() {
        for (words, is_there) in [
            (&["try", "a", "--variant", "x"][..], true),
            (&["try", "a", "--variant=x"], true),
            (&["try", "runs--variant/a"], false),
            (&["try", "a --variant b"], false),
            (&["try", "it's a --variant b"], false),
            (&["try", "it's", "--variant", "x"], true),
        ] {
            assert_eq!(has_option(&command_line(words), "--variant"), is_there, "{words:?}");
        }
    }
}
