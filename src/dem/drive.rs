//! The time loop: force pass, rows and frames, kick and drift, lists, guard.

use super::forces::{Workspace, evaluate};
use super::law::{Rule, Slip};
use super::motion::Leap;
use super::setting::Setting;
use super::state::{Load, State};
use super::{
    DemError, Observer, Summary, arrive, averaged_motion, bond, checkpoint, extra, guard, handover,
    ledger, leeway, limit, lost, motion, neighbours, onward, pushes, servo, zeroing,
};
use crate::model::{Cost, Model, Outcome, Scheme};
use crate::num::{Job, Vec3, clock};
use std::time::Instant;

/// Steps between two progress reports.
const REPORT_EVERY: u64 = 256;

/// Where a run begins.
pub enum Origin<'a> {
    /// At time 0, from the bodies of the model.
    Model,
    /// At a checkpoint of the same model.
    Checkpoint(&'a [u8]),
    /// At time 0, from a state whose sizes, masses and friction may have changed since: its
    /// places, velocities and contact memories go on.
    State(Box<State>),
}

/// See [`super::simulate`]; the state at the end is handed back whole if it is to be kept.
pub fn simulate(
    model: &Model,
    origin: Origin<'_>,
    (job, keep): (&Job, bool),
    observer: &mut dyn Observer,
) -> Result<(Summary, State), DemError> {
    let (begun, cpu) = (Instant::now(), clock::cpu_seconds());
    super::usable(model)?;
    let advice = limit::advise(model);
    let step = model.plan.step;
    if !model.plan.insist && step > advice.limit {
        return Err(DemError::StepTooLarge { step, limit: advice.limit, reason: advice.reason });
    }
    let deepest = advice.deepest.filter(|worst| worst.depth > model.plan.guard.overlap);
    let watched = model.plan.guard.overlap > 0.0 && model.plan.zero_every == 0;
    let fresh = !matches!(origin, Origin::Checkpoint(_));
    if let (Some(worst), true) = (deepest, watched && fresh) {
        return Err(DemError::Overlap {
            worst: worst.to_string(),
            limit: model.plan.guard.overlap,
        });
    }
    let mut setting = Setting::new(model);
    let mut watch = guard::Watch::default();
    let mut work = Workspace::new(job.threads, model.spheres.len());
    let (mut state, mut stopped) = match origin {
        Origin::Checkpoint(bytes) => {
            let state = checkpoint::read(model, bytes)?;
            place_for_looks(&mut setting, &state);
            (state, None)
        }
        Origin::State(mut state) => {
            state.begin_again(&setting);
            start(&mut setting, *state, &mut work, &mut watch, observer)
        }
        Origin::Model => {
            let state = State::new(&setting);
            start(&mut setting, state, &mut work, &mut watch, observer)
        }
    };
    let (from, loop_begun) = (state.step, Instant::now());
    let mut outcome = None;
    // Whether the second half kick of the last step is still to be done: where nothing looks
    // at velocities in between, it is done together with the first of the next step.
    let mut owed = false;
    while stopped.is_none() && state.step < model.plan.steps {
        let cancelled = job.is_cancelled();
        // Spheres that are ahead of the step have to be waited for.
        if cancelled && work.margin.went.is_none() {
            if owed {
                motion::finish(&setting, &mut state);
            }
            if guard::finite(&state) {
                observer.checkpoint(&checkpoint::write(model, &state)?);
            }
            outcome = Some(Outcome::Cancelled { step: state.step });
            break;
        }
        owed =
            one_step(&mut setting, &mut state, &mut work, (owed, (!cancelled).then_some(&watch)));
        stopped = watch.after_step(&setting, &state).or_else(|| arrive::blocked(&setting, &state));
        if stopped.is_some() && owed {
            motion::finish(&setting, &mut state);
        }
        zeroing::apply(&setting, &mut state);
        lost::apply(&setting, &mut state);
        if stopped.is_some() || is_due(&setting, state.step) {
            record(&setting, &mut state, observer, stopped.is_some())?;
        }
        if state.step.is_multiple_of(REPORT_EVERY) {
            job.report("steps", state.step, model.plan.steps);
        }
    }
    let stopped = stopped.or_else(|| watch.look(&setting, &state, true));
    if stopped.is_some() {
        keep_the_good(&setting, &state, &mut watch, observer)?;
    }
    let loop_seconds = loop_begun.elapsed().as_secs_f64();
    let outcome = outcome.unwrap_or(match stopped {
        None => Outcome::Finished,
        Some(reason) => {
            Outcome::Stopped { step: state.step, time: state.step as f64 * step, reason }
        }
    });
    let steps = state.step - from;
    // What is left to say takes memory of its own.
    drop(work);
    state.built = Vec::new();
    if !keep {
        state.loads = Vec::new();
    }
    let summary = Summary {
        outcome,
        touches: ledger::touches(&setting, &state),
        breaks: state.bonds.broken.clone(),
        springs: match observer.wants_springs() {
            true => handover::springs(&setting, &state),
            false => Vec::new(),
        },
        cost: Cost {
            cpu_seconds: clock::since(cpu, begun),
            wall_seconds: begun.elapsed().as_secs_f64(),
            loop_seconds: Some(loop_seconds),
            steps,
            sphere_steps: steps * model.spheres.len() as u64,
            peak_bytes: clock::peak_bytes(),
        },
        advice,
        rebuilds: state.rebuilds,
        notes: lost::notes(&setting, &state)
            .into_iter()
            .chain(watch.notes)
            .chain(servo::notes(model, &state.servos))
            .collect(),
    };
    Ok((summary, state))
}

/// Lists, force pass and output at time 0.
fn start(
    setting: &mut Setting<'_>,
    mut state: State,
    work: &mut Workspace,
    watch: &mut guard::Watch,
    observer: &mut dyn Observer,
) -> (State, Option<String>) {
    neighbours::rebuild(setting, &mut state, &work.crew);
    handover::take_up(setting, &mut state);
    set_up_pass(setting, &mut state, work);
    // The guard looks at the contacts of the last pass.
    let stopped = watch.look(setting, &state, false);
    let ledger = (
        ledger::kinetic(setting, &state) + ledger::stored(setting, &state),
        ledger::potential(setting, &state),
    );
    (state.ledger.start, state.ledger.start_potential) = ledger;
    if guard::finite(&state) {
        hand_over(setting, &state, observer, setting.model.plan.steps == 0);
        observer.row(&ledger::row(setting, &state));
    }
    (state, stopped)
}

/// Hands over what can be looked at and gone on from after the guard has stopped a run: a
/// checkpoint of the state, or where it holds numbers that are not finite, the last good frame.
fn keep_the_good(
    setting: &Setting<'_>,
    state: &State,
    watch: &mut guard::Watch,
    observer: &mut dyn Observer,
) -> Result<(), DemError> {
    if guard::finite(state) {
        observer.checkpoint(&checkpoint::write(setting.model, state)?);
    } else if let Some(good) = watch.good.take().filter(|good| good.step > 0) {
        observer.frame(&good);
    }
    Ok(())
}

/// From one force pass to just after the next. `owed` in and out: whether the second half
/// kick is still to be done. Spheres go ahead of the step only if `watch` does not look at it; `None` if it is the last.
fn one_step(
    setting: &mut Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    (owed, watch): (bool, Option<&guard::Watch>),
) -> bool {
    if setting.scheme == Scheme::PathAveraged {
        averaged_step(setting, state, work);
        return false;
    }
    state.ledger.add_half();
    move_walls(setting, state, (state.step + 1) as f64 * setting.step);
    let far = motion::advance(setting, state, (&work.crew, &mut work.margin), owed);
    let came = setting.scheme != Scheme::Lammps && arrive::now(setting, state, true);
    if far | came | lists_are_old(setting, state) {
        work.forget_lists();
        neighbours::rebuild(setting, state, &work.crew);
    }
    let owed = !is_due(setting, state.step);
    let unseen = owed && watch.is_some_and(|watch| !watch.looks_at(state));
    let leap = Leap::new(setting, state, owed);
    let ahead = unseen && work.crew.size() == 1 && onward::fits(setting, state);
    pass(setting, state, work, (Look::After(!unseen), ahead.then_some(&leap)));
    if !owed {
        motion::finish(setting, state);
    }
    if setting.scheme == Scheme::Lammps && arrive::now(setting, state, false) {
        begin_again(setting, state, work);
    }
    owed
}

/// What LAMMPS does between two `run` commands: new lists, and the set-up pass once more.
fn begin_again(setting: &mut Setting<'_>, state: &mut State, work: &mut Workspace) {
    work.forget_lists();
    neighbours::rebuild(setting, state, &work.crew);
    set_up_pass(setting, state, work);
}

/// The force pass before the first step of a run.
fn set_up_pass(setting: &mut Setting<'_>, state: &mut State, work: &mut Workspace) {
    let walls = setting.walls.clone();
    setting.rest_for_set_up();
    work.forget_walls();
    force_pass(setting, state, work, true);
    setting.walls = walls;
}

/// Whether something besides motion asks for new lists.
fn lists_are_old(setting: &Setting<'_>, state: &mut State) -> bool {
    state.bonds.take_changed() | state.gone.take_changed() || leeway::too_long(setting, state)
}

/// Whether velocities are looked at after step `step`: something is written, or the guard
/// does its sums.
fn is_due(setting: &Setting<'_>, step: u64) -> bool {
    let plan = &setting.model.plan;
    let every = |steps: u64| step.is_multiple_of(steps.max(1));
    step == plan.steps
        || zeroing::due(plan, step)
        || arrive::due(setting, step)
        || every(plan.frame_every)
        || every(plan.series_every)
        || every(guard::EVERY)
        || (plan.checkpoint_every > 0 && every(plan.checkpoint_every))
}

/// Half a step, force pass, half a step.
fn averaged_step(setting: &mut Setting<'_>, state: &mut State, work: &mut Workspace) {
    move_walls(setting, state, (state.step as f64 + 0.5) * setting.step);
    if averaged_motion::first_half(setting, state) | lists_are_old(setting, state) {
        work.forget_lists();
        neighbours::rebuild(setting, state, &work.crew);
    }
    force_pass(setting, state, work, false);
    averaged_motion::second_half(setting, state);
    if arrive::now(setting, state, false) {
        state.gone.change();
    }
    place_for_looks(setting, state);
    // Powers act over the whole of this step.
    state.ledger.add_half();
}

/// Walls to where the next pass, at `time`, finds them.
fn move_walls(setting: &mut Setting<'_>, state: &mut State, time: f64) {
    if setting.needs.servo_walls {
        servo::advance(setting, state);
    }
    setting.place_walls(&state.servos, time, 0.0);
}

/// Walls to where they are at the end of a step, for what is written then.
fn place_for_looks(setting: &mut Setting<'_>, state: &State) {
    let averaged = setting.scheme == Scheme::PathAveraged && state.step > 0;
    let ahead = if averaged { 0.5 * setting.step } else { 0.0 };
    setting.place_walls(&state.servos, state.step as f64 * setting.step, ahead);
}

/// Contact forces, local damping, and their energies.
pub(super) fn force_pass(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    first: bool,
) {
    let look = if first { Look::First } else { Look::After(true) };
    pass(setting, state, work, (look, None));
}

/// What a force pass is for.
enum Look {
    /// To begin with.
    First,
    /// For a step, and whether somebody looks at forces after it.
    After(bool),
}

/// The same; spheres go `onward` during it where that is given.
fn pass(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    (look, onward): (Look, Option<&Leap>),
) {
    let first = matches!(look, Look::First);
    let needs = &setting.needs;
    let rule = Rule {
        law: setting.law,
        advance: if first && setting.scheme != Scheme::Yade { 0.0 } else { setting.step },
        interval: if first { 0.0 } else { setting.step },
        slip: match setting.scheme {
            Scheme::Lammps if first => Slip::Bare,
            Scheme::Liggghts if first => Slip::Kept,
            _ => Slip::Cut,
        },
        // A run that waits for grains may end at any step.
        seen: !matches!(look, Look::After(false)) || needs.servo_walls || needs.arrivals,
    };
    let mut tally = evaluate(setting, state, work, (&rule, onward));
    tally += bond::pass(setting, state, &rule, first);
    let (extra, attraction) = extra::pass(setting, state, &rule);
    tally += extra;
    let turned = match setting.needs.servo_walls {
        true => servo::respond(setting, state, &attraction),
        false => 0.0,
    };
    tally.drag_power = extra::drag(setting, state, first);
    if setting.planar {
        for Load { force, torque } in &mut state.loads {
            force.z = 0.0;
            *torque = Vec3::new(0.0, 0.0, torque.z);
        }
    }
    state.gather_solids(setting);
    if let Some(law) = &setting.model.mutual {
        work.far.add(setting, state, law);
    }
    let damping = motion::damp(setting, state, first);
    state.ledger.add(tally, damping, setting.step, first);
    state.ledger.wall_half += 0.5 * setting.step * turned;
}

/// A frame, and contact forces if they are wanted with it.
fn hand_over(setting: &Setting<'_>, state: &State, observer: &mut dyn Observer, last: bool) {
    let pushes = observer.wants_pushes(last);
    if !observer.wants_frames() && !pushes {
        return;
    }
    let frame = state.frame(setting);
    observer.frame(&frame);
    if pushes {
        observer.pushes(&frame, pushes::pushes(setting, state));
    }
}

/// Frames, rows and checkpoints that are due.
fn record(
    setting: &Setting<'_>,
    state: &mut State,
    observer: &mut dyn Observer,
    last: bool,
) -> Result<(), DemError> {
    if !guard::finite(state) {
        // Nothing that is not a number leaves this room; the guard ends the run.
        return Ok(());
    }
    let plan = &setting.model.plan;
    let last = last || state.step == plan.steps;
    if last || state.step.is_multiple_of(plan.frame_every.max(1)) {
        hand_over(setting, state, observer, last);
    }
    if last || state.step.is_multiple_of(plan.series_every.max(1)) {
        observer.row(&ledger::row(setting, state));
    }
    if plan.checkpoint_every > 0 && state.step.is_multiple_of(plan.checkpoint_every) {
        observer.checkpoint(&checkpoint::write(setting.model, state)?);
    }
    Ok(())
}
