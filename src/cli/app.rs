//! `vesica [SCENE]`: the terminal app.

use super::error::CliError;
use super::numbers;
use super::shell::{scenes, settings};
use crate::scene::preset;
use crate::study::sweep::SweepFolder;
use crate::tui::brake;
use crate::tui::figures::save_figures;
use crate::tui::glyphs::Parts;
use crate::tui::state::Slot;
use crate::tui::theme::ColorTier;
use crate::tui::{self, Failed, Options, SweepMap, SweepOutcome};
use clap::ValueEnum;
use clap_complete::ArgValueCompleter;
use std::ffi::{OsStr, OsString};
use std::io::{self, IsTerminal};
use std::path::Path;

/// Arguments of the app.
#[derive(Debug, clap::Args)]
#[group(id = "app")]
pub(super) struct Arguments {
    /// The scene that the terminal app opens: a preset's name, a TOML file, or the folder of a run or of a sweep
    /// [default: case3-quick]
    #[arg(add = ArgValueCompleter::new(scenes))]
    pub scene: Option<OsString>,

    /// Override a value of the scene, such as anchoring.kind=parallel
    #[arg(long, value_name = "KEY=VALUE", add = ArgValueCompleter::new(settings))]
    set: Vec<String>,

    /// Frames a second, at most
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = numbers::frames,
          allow_negative_numbers = true)]
    fps: u32,

    /// Compute in N threads, of which the runs of the gallery have a share each [default: as many as there are and pay]
    #[arg(long, value_name = "N", value_parser = numbers::threads, allow_negative_numbers = true)]
    threads: Option<usize>,

    /// Take at least this long to show a run from 0 to its end; 0: show it as fast as it is computed
    #[arg(long, value_name = "SECONDS", default_value_t = brake::DEFAULT_SECONDS,
          value_parser = numbers::pace, allow_negative_numbers = true)]
    pace: f64,

    /// Colours of the terminal; auto: what it says of itself
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Color::Auto)]
    color: Color,

    /// Glyphs that the membrane and the director are drawn with; octant and braille are finer, and need a font that
    /// has them
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = GlyphSet::Block)]
    glyphs: GlyphSet,
}

/// What lines are drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GlyphSet {
    /// Quarters of a cell, which every font has
    Block,
    /// Eighths of a cell
    Octant,
    /// Eight dots a cell
    Braille,
}

impl GlyphSet {
    fn parts(self) -> Parts {
        match self {
            Self::Block => Parts::Quadrants,
            Self::Octant => Parts::Octants,
            Self::Braille => Parts::Braille,
        }
    }
}

/// Values of TERM for what cannot place text, such as an editor's shell or a printer, or has no second screen
/// to leave the first one as it was.
const INCAPABLE: [&str; 19] = [
    "",
    "adm3a",
    "ansi",
    "ansi-m",
    "ansi-mini",
    "ansi.sys",
    "dialup",
    "dumb",
    "dumb-emacs-ansi",
    "emacs",
    "glasstty",
    "hardcopy",
    "network",
    "none",
    "plugboard",
    "switch",
    "tty",
    "unknown",
    "vt52",
];

/// Whether the app cannot be drawn on a terminal of this name.
fn is_incapable(name: &str) -> bool {
    let name = name.trim();
    INCAPABLE
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// How many colours to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Color {
    /// What the terminal says of itself
    Auto,
    /// 24 bits
    True,
    /// The palette of 256
    #[value(name = "256")]
    Palette,
    /// The terminal's own 16
    #[value(name = "16")]
    Basic,
    /// Glyphs alone
    None,
}

impl Color {
    fn tier(self) -> Option<ColorTier> {
        match self {
            Self::Auto => None,
            Self::True => Some(ColorTier::True),
            Self::Palette => Some(ColorTier::Palette),
            Self::Basic => Some(ColorTier::Basic),
            Self::None => Some(ColorTier::None),
        }
    }
}

/// Opens the app on a scene. A wrong scene and a missing terminal are reported before the terminal is
/// touched.
pub(super) fn open(arguments: Arguments) -> Result<(), CliError> {
    let scene = arguments.scene.clone().unwrap_or(tui::DEFAULT.into());
    let is_preset = scene.to_str().is_some_and(|name| preset(name).is_some());
    if !is_preset && SweepFolder::is_one(Path::new(&scene)) {
        check_terminal(&scene)?;
        return open_sweep(Path::new(&scene), &arguments);
    }
    let (slots, active) = tui::open_with_cases(&scene, &arguments.set)?;
    super::run::some_step(&slots[active].scene.time)?;
    check_terminal(&scene)?;
    run(slots, active, &arguments)
}

/// Shows the map of a sweep, and the runs that are opened from it.
fn open_sweep(path: &Path, arguments: &Arguments) -> Result<(), CliError> {
    if !arguments.set.is_empty() {
        return Err(CliError::SetInRun {
            folder: path.join("base"),
        });
    }
    let folder = SweepFolder::open(path)?;
    let mut map = SweepMap::new(&folder)?;
    loop {
        match tui::show_sweep(&folder, &mut map, arguments.color.tier())? {
            SweepOutcome::Ended(ending) => {
                return match ending.signal() {
                    Some(number) => Err(CliError::AppEnded { number }),
                    None => Ok(()),
                };
            }
            SweepOutcome::Open(path) => match tui::open_with_cases(path.as_os_str(), &[]) {
                // A run that failed is reported in its own exit; the map goes on.
                Ok((slots, active)) => match run(slots, active, arguments) {
                    Ok(()) | Err(CliError::AppFailed { .. }) => {}
                    Err(error) => return Err(error),
                },
                Err(error) => map.remark = Some(error.to_string()),
            },
        }
    }
}

/// Checks that the app can be drawn.
fn check_terminal(scene: &OsStr) -> Result<(), CliError> {
    let scene = scene.to_owned();
    for (stream, is_terminal) in [
        ("output", io::stdout().is_terminal()),
        ("input", io::stdin().is_terminal()),
    ] {
        if !is_terminal {
            return Err(CliError::NoTerminal { stream, scene });
        }
    }
    let name = std::env::var("TERM").unwrap_or_default();
    if is_incapable(&name) {
        return Err(CliError::IncapableTerminal { name, scene });
    }
    Ok(())
}

/// Runs the app.
fn run(slots: Vec<Slot>, active: usize, arguments: &Arguments) -> Result<(), CliError> {
    let outcome = tui::run(Options {
        slots,
        active,
        frames_per_second: arguments.fps,
        threads: arguments.threads,
        pace: arguments.pace,
        tier: arguments.color.tier(),
        parts: arguments.glyphs.parts(),
        save: save_figures,
    })?;
    match (outcome.ending.signal(), outcome.failed) {
        (Some(number), _) => Err(CliError::AppEnded { number }),
        (None, Some(Failed { is_of_scene })) => Err(CliError::AppFailed { is_of_scene }),
        (None, None) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_that_can_show_the_app_are_told_from_those_that_cannot() {
        for name in [
            "", "dumb", "DUMB", "Unknown", "none", "vt52", "ansi", " dumb",
        ] {
            assert!(is_incapable(name), "{name}");
        }
        for name in [
            "xterm",
            "xterm-256color",
            "screen",
            "screen.xterm-256color",
            "tmux",
            "tmux-256color",
            "linux",
            "rxvt-unicode-256color",
            "foot",
            "alacritty",
            "kitty",
            "xterm-kitty",
            "wezterm",
            "vt100",
            "vt220",
        ] {
            assert!(!is_incapable(name), "{name}");
        }
    }
}
