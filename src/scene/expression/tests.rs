//! What formulas give, and what is said of wrong ones.

use super::*;
use proptest::prelude::*;

fn value(text: &str) -> f64 {
    text.parse::<Expression>().expect(text).evaluate(0.25, 0.75)
}

fn error(text: &str) -> ExpressionError {
    text.parse::<Expression>().expect_err(text)
}

#[test]
fn the_usual_rules_of_precedence_hold() {
    assert_eq!(value("-x^2"), -0.0625);
    assert_eq!(value("2^3^2"), 512.0);
    assert_eq!(value("2^-1"), 0.5);
    assert_eq!(value("10 - 2 - 3"), 5.0);
    assert_eq!(value("10 / 2 / 5"), 1.0);
    assert_eq!(value("10 / 2 * 5"), 25.0);
    assert_eq!(value("1 + 2 * 3 ^ 2"), 19.0);
    assert_eq!(value("2 * -3"), -6.0);
    assert_eq!(value("2 / -x ^ 2"), -32.0);
    assert_eq!(value("--x"), 0.25);
    assert_eq!(value("(1 + 2) * 3"), 9.0);
}

#[test]
fn numbers_names_and_functions() {
    assert_eq!(value("1.5e-3"), 1.5e-3);
    assert_eq!(value("1E3 + .5 + 2."), 1002.5);
    assert_eq!(value("x - y"), -0.5);
    assert_eq!(value("sin(pi / 2)"), 1.0);
    assert_eq!(value("ln(e)"), 1.0);
    assert_eq!(value("max(1, max(2, 3)) * 2"), 6.0);
    assert_eq!(value("atan2(y - 0.75, x)"), 0.0);
    assert_eq!(value("sign(0) + sign(-3)"), -1.0);
    assert_eq!(value("\t1\n+ 1 "), 2.0);
}

#[test]
fn errors_say_where_and_what() {
    let unknown = error("1 + xx");
    assert_eq!(unknown.range, 4..6);
    assert!(
        unknown.to_string().contains("did you mean 'x'?"),
        "{unknown}"
    );
    assert!(error("z").to_string().contains("Allowed: x, y, pi, e"));
    assert_eq!(error("2x").range, 1..2);
    assert_eq!(error("2e").range, 1..2);
    assert_eq!(
        error("1 +").problem,
        ExpressionProblem::Incomplete {
            expected: "a number, x, y, a function or '('"
        }
    );
    assert!(matches!(
        error("").problem,
        ExpressionProblem::Incomplete { .. }
    ));
    assert!(matches!(
        error("(x").problem,
        ExpressionProblem::Incomplete { .. }
    ));
    assert!(matches!(
        error("sin x").problem,
        ExpressionProblem::Unexpected { .. }
    ));
    assert!(matches!(
        error("x)").problem,
        ExpressionProblem::Unexpected { .. }
    ));
    assert!(matches!(
        error(".").problem,
        ExpressionProblem::Unexpected { .. }
    ));
    assert!(matches!(
        error("x(2)").problem,
        ExpressionProblem::UnknownName { .. }
    ));
    assert_eq!(
        error("max(1)").problem,
        ExpressionProblem::Arguments {
            function: "max",
            expected: 2,
            found: 1
        }
    );
    assert!(matches!(
        error("sin(1, 2)").problem,
        ExpressionProblem::Arguments { .. }
    ));
}

#[test]
fn what_is_suggested_may_stand_there() {
    for (text, words) in [
        ("sqr(x)", "; did you mean 'sqrt'?"),
        (
            "log(x)",
            "unknown name 'log' in the expression; did you mean ln, log10 or log2?",
        ),
        ("LOG(x)", "; did you mean ln, log10 or log2?"),
        ("lg(x)", "; did you mean log10?"),
        ("sgn(x)", "; did you mean sign?"),
        ("pow(x, 2)", "; did you mean a^b?"),
        ("arctan(x)", "; did you mean 'atan'?"),
        ("PI", "; did you mean 'pi'?"),
        (
            "2*r",
            "; did you mean sqrt(x^2 + y^2), the distance from (0, 0)?",
        ),
        ("theta", "; did you mean atan2(y, x), the polar angle?"),
        (
            "log",
            "; did you mean ln, log10 or log2, with its argument in parentheses?",
        ),
        (
            "logx",
            "; did you mean ln, log10 or log2, with the argument in parentheses: (x)?",
        ),
        (
            "sinx",
            "; did you mean sin, with the argument in parentheses: (x)?",
        ),
    ] {
        let error = error(text).to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
    for text in ["x(2)", "pi(2)", "roun", "sinn", "logg", "powx", "z"] {
        let problem = error(text).problem;
        let is_silent = matches!(problem, ExpressionProblem::UnknownName { meant: None, .. });
        assert!(is_silent, "{text}: {problem}");
    }
    // None of those elsewhere is one here, and what is written in their place can be read.
    for (elsewhere, _) in FUNCTIONS_ELSEWHERE.iter().chain(&VARIABLES_ELSEWHERE) {
        let mut here = FUNCTIONS.iter().chain(&CONSTANTS);
        assert!(here.all(|(known, _)| known != elsewhere), "{elsewhere}");
    }
    for (_, here) in VARIABLES_ELSEWHERE {
        let formula = here.split(", the ").next().unwrap_or_default();
        assert!(formula.parse::<Expression>().is_ok(), "{here}");
    }
}

#[test]
fn depth_and_length_are_bounded() {
    let deep = |n| format!("{}1{}", "(".repeat(n), ")".repeat(n));
    assert_eq!(value(&deep(DEEPEST_NESTING - 1)), 1.0);
    assert_eq!(
        error(&deep(DEEPEST_NESTING)).problem,
        ExpressionProblem::TooDeep
    );
    for opening in ["(", "-", "2^", "sin("] {
        assert_eq!(
            error(&opening.repeat(1000)).problem,
            ExpressionProblem::TooDeep
        );
    }
    let sum = |terms: usize| vec!["1"; terms].join("+");
    assert_eq!(value(&sum(LONGEST_TEXT / 2)), LONGEST_TEXT as f64 / 2.0);
    assert_eq!(
        error(&sum(LONGEST_TEXT / 2 + 1)).problem,
        ExpressionProblem::TooLong
    );
}

#[test]
fn what_is_not_finite_is_found() {
    let pole: Expression = "1 / (x - 0.5)".parse().expect("well formed");
    let error = pole.check_finite(4).expect_err("a pole at a node");
    let problem = ExpressionProblem::NotFinite {
        value: f64::INFINITY,
        x: 0.5,
        y: 0.0,
    };
    assert_eq!(error.problem, problem);
    assert_eq!(pole.check_finite(5), Ok(()));
    let root: Expression = "sqrt(y - 0.1)".parse().expect("well formed");
    assert!(root.check_finite(5).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_text_makes_it_panic(text in "[-+*/^(),.0-9 xyesinmaxpi_é]{0,40}") {
        if let Ok(expression) = text.parse::<Expression>() {
            expression.evaluate(0.3, 0.7);
        }
    }
}
