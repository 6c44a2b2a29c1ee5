//! The command line: arguments, one file a verb, messages, exit codes. Only this
//! room prints and exits.

mod arguments;
mod check;
mod compare;
mod convert;
mod demo;
mod export;
mod generate;
mod list;
mod measure;
mod new;
mod output;
mod pack;
mod reproduce;
mod run;
mod study;
mod sweep;
mod view;

use arguments::{Arguments, Verb};
use clap::{CommandFactory, Parser};
pub use output::{Ending, Screen};
use std::process::ExitCode;

/// Parses the command line, does what it says, turns the ending into an exit code.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let screen = match Screen::new(&arguments) {
        Ok(screen) => screen,
        Err(message) => {
            eprintln!("riprap: {message}");
            return ExitCode::from(1);
        }
    };
    let ending = act(arguments.verb, &screen);
    screen.close(ending)
}

fn act(verb: Verb, screen: &Screen) -> Result<(), Ending> {
    match verb {
        Verb::Demo(arguments) => demo::demo(&arguments, screen),
        Verb::New(arguments) => new::new(&arguments, screen),
        Verb::List(arguments) => list::list(&arguments, screen),
        Verb::Check(arguments) => check::check(&arguments, screen),
        Verb::Generate(arguments) => generate::generate(&arguments, screen),
        Verb::Reproduce(arguments) => reproduce::reproduce(&arguments, screen),
        Verb::Pack(arguments) => pack::pack(&arguments, screen),
        Verb::Run(arguments) => run::run(&arguments, screen),
        Verb::Export(arguments) => export::export(&arguments, screen),
        Verb::Compare(arguments) => compare::compare(&arguments, screen),
        Verb::Study(arguments) => study::study(&arguments, screen),
        Verb::Sweep(arguments) => sweep::sweep(&arguments, screen),
        Verb::Measure(arguments) => measure::measure(&arguments, screen),
        Verb::Convert(arguments) => convert::convert(&arguments, screen),
        Verb::View(arguments) => view::view(&arguments, screen),
        Verb::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "riprap", &mut text);
            screen.script("completions", &text)
        }
        Verb::Man => {
            let mut text = Vec::new();
            clap_mangen::Man::new(Arguments::command()).render(&mut text).map_err(Ending::from)?;
            screen.script("man", &text)
        }
    }
}
