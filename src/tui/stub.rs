use super::message::Effect;
use super::state::*;
use crate::simulation::RunId;
impl App {
    pub fn open(slot: Slot, size: (u16, u16), frames_per_second: u32) -> (Self, Vec<Effect>) {
        (
            Self {
                slots: vec![slot],
                active: 0,
                screen: Screen::Run,
                overlay: None,
                view: View {
                    field: Field::Phase,
                    director: DirectorStyle::Arrows,
                    colour_map: 0,
                    logarithmic: false,
                },
                focus: Panel::Field,
                looking_back: None,
                size,
                frames_per_second,
                saving: Saving::Idle,
                remark: None,
                stale: true,
                next_run: RunId(1),
                ending: None,
            },
            vec![],
        )
    }
}
