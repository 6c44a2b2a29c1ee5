//! `riprap demo`: the main job on a built-in scene.

use super::arguments::Demo;
use super::compare::{chosen, conclude};
use super::{Ending, Screen};
use crate::scene::road::Road;
use crate::scene::shipped::find;

pub fn demo(arguments: &Demo, screen: &Screen) -> Result<(), Ending> {
    let scene = find("demo").ok_or_else(|| Ending::Work("the demo scene is missing".to_owned()))?;
    let path = arguments.output.join("scene.toml");
    let path = match std::fs::read_to_string(&path) {
        Ok(text) if text == scene.text => path,
        Ok(_) => {
            let message = "exists and is another scene; choose another folder with -o";
            return Err(Ending::Input(format!("{} {message}", path.display())));
        }
        Err(_) => scene.copy_to(&arguments.output)?,
    };
    let solvers = chosen(&[], screen)?;
    let mut road = Road::open(&path, None, screen.job())?;
    let compared = road.compare(&solvers)?;
    screen.remarks(&mut road);
    conclude(&road, &compared, screen)
}
