//! `vesica completions SHELL` and `vesica man`: what packagers install beside the program, and what a shell asks the
//! program when somebody presses Tab.

use super::Arguments as Program;
use super::error::CliError;
use super::output;
use crate::record::{RecordError, make_folder};
use crate::scene::{preset_description, preset_names, tables};
use clap::CommandFactory;
use clap_complete::CompleteEnv;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::{EnvCompleter, Fish, Zsh};
use std::ffi::OsStr;
use std::path::PathBuf;

/// The variable by which a shell asks for completions.
const ASKED: &str = "VESICA_COMPLETE";

/// The program's name, as it is called.
const NAME: &str = "vesica";

/// What bash is to run. clap_complete's own script passes on the words that bash makes, and for bash `=` and `:` end a word:
/// `--set anchoring.kind=p` would be four of them. This one takes what stands without a blank between as one word, and
/// of each candidate gives bash the part that stands for the last of its words.
const BASH: &str = r#"_vesica() {
    local rest=${COMP_LINE:0:COMP_POINT} words=() i IFS=$'\013'
    for ((i = 0; i <= COMP_CWORD; i++)); do
        if [[ $i == 0 || $rest == [[:space:]]* ]]; then
            words+=("")
            rest=${rest#"${rest%%[![:space:]]*}"}
        fi
        local word=${COMP_WORDS[i]}
        [[ $i != "$COMP_CWORD" ]] || word=$rest
        words[${#words[@]} - 1]+=$word
        rest=${rest#"$word"}
    done
    local last=$((${#words[@]} - 1))
    local before=${words[last]%"$2"}
    COMPREPLY=($(_CLAP_IFS=$IFS _CLAP_COMPLETE_INDEX=$last VESICA_COMPLETE=bash vesica -- "${words[@]}")) || COMPREPLY=()
    COMPREPLY=("${COMPREPLY[@]#"$before"}")
    if [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *[=/:] ]]; then
        compopt -o nospace
    fi
}
complete -o nosort -o bashdefault -F _vesica vesica
"#;

/// Arguments of `vesica completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
For this shell alone:  source <(vesica completions bash)  or  vesica completions fish | source
For all, as packages do it, the file that is printed goes to
  bash  share/bash-completion/completions/vesica
  zsh   share/zsh/site-functions/_vesica
  fish  share/fish/vendor_completions.d/vesica.fish
It asks the program, so that it stays right when the program changes. Scenes, and the keys of --set, are completed too.")]
pub(super) struct CompletionArguments {
    /// The shell
    shell: Shell,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Shell {
    Bash,
    Zsh,
    Fish,
}

/// Answers a shell that asks for completions, and ends the process; does nothing otherwise.
pub(super) fn answer() {
    CompleteEnv::with_factory(Program::command)
        .var(ASKED)
        .complete();
}

/// Prints what a shell is to run.
pub(super) fn completions(arguments: &CompletionArguments) -> Result<(), CliError> {
    let shell: &dyn EnvCompleter = match arguments.shell {
        Shell::Bash => return output::print(BASH),
        Shell::Zsh => &Zsh,
        Shell::Fish => &Fish,
    };
    let mut script = Vec::new();
    shell
        .write_registration(ASKED, NAME, NAME, NAME, &mut script)
        .map_err(CliError::Output)?;
    output::print(&String::from_utf8_lossy(&script))
}

/// Arguments of `vesica man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Read it with:  vesica man | man -l -")]
pub(super) struct ManArguments {
    /// Write a page for the program and one for each command into this folder [default: print that of the program]
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: Option<PathBuf>,
}

/// Prints or writes the manual.
pub(super) fn man(arguments: &ManArguments) -> Result<(), CliError> {
    let program = Program::command();
    match &arguments.out {
        Some(folder) => {
            make_folder(folder)?;
            let written = clap_mangen::generate_to(program, folder);
            Ok(written.map_err(RecordError::write(folder))?)
        }
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(program)
                .render(&mut page)
                .map_err(CliError::Output)?;
            output::print(&String::from_utf8_lossy(&page))
        }
    }
}

/// Completes SCENE: presets, and files and folders.
pub(super) fn scenes(begun: &OsStr) -> Vec<CompletionCandidate> {
    let begun_word = begun.to_string_lossy();
    let presets = preset_names().filter(|name| name.starts_with(&*begun_word));
    let described = |name: &str| {
        let words = preset_description(name).map(Into::into);
        CompletionCandidate::new(name).help(words)
    };
    let mut candidates: Vec<CompletionCandidate> = presets.map(described).collect();
    candidates.extend(PathCompleter::any().complete(begun));
    candidates
}

/// Completes KEY=VALUE: the keys of a scene, and after `=` the words that the key may have.
pub(super) fn settings(begun: &OsStr) -> Vec<CompletionCandidate> {
    let begun = begun.to_string_lossy();
    let candidates = match begun.split_once('=') {
        None => keys(),
        Some((key, _)) => values(key),
    };
    let fitting = candidates
        .into_iter()
        .filter(|(text, _)| text.starts_with(&*begun));
    fitting
        .map(|(text, words)| CompletionCandidate::new(text).help(Some(words.into())))
        .collect()
}

/// `table.key=` of every parameter, with what it is.
fn keys() -> Vec<(String, String)> {
    let tables = tables();
    let keys = tables.iter().flat_map(|table| {
        let key = move |key: &str| format!("{}.{key}=", table.name);
        table
            .parameters
            .iter()
            .map(move |parameter| (key(parameter.key), parameter.words.trim().to_owned()))
    });
    keys.collect()
}

/// `table.key=word` for every word that the key may have.
fn values(key: &str) -> Vec<(String, String)> {
    let tables = tables();
    let Some((table, name)) = key.split_once('.') else {
        return Vec::new();
    };
    let parameter = tables
        .iter()
        .filter(|info| info.name == table)
        .flat_map(|info| &info.parameters)
        .find(|parameter| parameter.key == name);
    let Some(parameter) = parameter else {
        return Vec::new();
    };
    // Choices are named in quotes.
    let words = parameter.allowed.split('"').skip(1).step_by(2);
    let is_word = |word: &&str| !word.is_empty() && !word.contains(char::is_whitespace);
    words
        .filter(is_word)
        .map(|word| (format!("{key}={word}"), parameter.words.trim().to_owned()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(candidates: Vec<CompletionCandidate>) -> Vec<String> {
        let text = |it: &CompletionCandidate| it.get_value().to_string_lossy().into_owned();
        candidates.iter().map(text).collect()
    }

    #[test]
    fn scenes_keys_and_their_words_are_completed() {
        let found = texts(scenes(OsStr::new("case3-")));
        assert!(found.contains(&"case3-quick".to_owned()), "{found:?}");
        assert!(found.iter().all(|name| name.starts_with("case3-")));
        let found = texts(settings(OsStr::new("anch")));
        assert!(found.contains(&"anchoring.kind=".to_owned()), "{found:?}");
        assert!(found.iter().all(|key| key.starts_with("anch")));
        let found = texts(settings(OsStr::new("anchoring.kind=p")));
        assert_eq!(found, ["anchoring.kind=parallel"]);
        assert_eq!(texts(settings(OsStr::new("mesh.cells=1"))), [""; 0]);
    }
}
