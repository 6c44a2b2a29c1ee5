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
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
                output::print_error(2, error.render().to_string().trim_end());
            }
            error.exit()
        }
    };
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

/// One page: the program, then each verb with its arguments.
fn manual(mut command: clap::Command) -> std::io::Result<Vec<u8>> {
    command.build();
    let mut page = Vec::new();
    let whole = clap_mangen::Man::new(command.clone());
    whole.render_title(&mut page)?;
    whole.render_name_section(&mut page)?;
    whole.render_synopsis_section(&mut page)?;
    whole.render_options_section(&mut page)?;
    for verb in command.get_subcommands().filter(|verb| verb.get_name() != "help") {
        let title = format!("riprap {}", verb.get_name());
        let mut own = Vec::new();
        // Options of all verbs stand above.
        let verb = verb.clone().mut_args(|argument| {
            let everywhere = argument.is_global_set() || argument.get_id() == "help";
            argument.hide(everywhere)
        });
        let verb = clap_mangen::Man::new(verb.bin_name(title.clone()));
        verb.render_description_section(&mut own)?;
        verb.render_synopsis_section(&mut own)?;
        verb.render_options_section(&mut own)?;
        let own = String::from_utf8_lossy(&own).replace(".SH DESCRIPTION\n", "");
        page.extend(format!(".SH \"{}\"\n", title.to_uppercase()).as_bytes());
        page.extend(own.replace(".SH ", ".SS ").as_bytes());
    }
    whole.render_extra_section(&mut page)?;
    whole.render_version_section(&mut page)?;
    Ok(page)
}

fn act(verb: Verb, screen: &Screen) -> Result<(), Ending> {
    match verb {
        Verb::Demo(arguments) => demo::demo(&arguments, screen),
        Verb::New(arguments) => new::new(&arguments, screen),
        Verb::List(arguments) => list::list(&arguments, screen),
        Verb::Check(arguments) => check::check(&arguments.scene, screen),
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
            let text = manual(Arguments::command()).map_err(Ending::from)?;
            screen.script("man", &text)
        }
    }
}
