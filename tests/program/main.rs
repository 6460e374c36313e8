//! The program's commands, as a user calls them: arguments in, files and messages and exit statuses out.

#[path = "../common/ignored.rs"]
mod ignored;

mod accuracy;
mod cli;
mod completions;
mod figures;
mod measured;
mod provenance;
mod resume;
mod streams;
mod sweep;
