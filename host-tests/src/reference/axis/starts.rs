//! Starts of an axis with the data of a FIFO.
use super::*;

impl Axis {
    pub fn start_pt(&mut self, fifo: usize, now_ns: i64) {
        let fifo = if self.pt.dynamic { 0 } else { fifo };
        self.chain = Chain::of(&self.pt.fifos[fifo]);
        let timed = Timed::new(self.chain.curve.clone(), Fix::ms(now_ns), self.x);
        (self.pt.running, self.pt.passes, self.began, self.ending) = (fifo, 0, true, Why::End);
        self.motion = Some(if self.pt.dynamic { Motion::Stream(timed, 0) } else { Motion::Pt(timed) });
    }

    /// Data of the FIFO that runs has changed.
    pub fn pt_grew(&mut self, fifo: usize) {
        let running = self.pt.running;
        let grows = match self.motion {
            Some(Motion::Pt(_)) => !self.pt.dynamic && running == fifo,
            _ => self.pt.dynamic,
        };
        if let Some(Motion::Pt(timed) | Motion::Stream(timed, _)) = &mut self.motion
            && grows
        {
            for segment in &self.pt.fifos[running][self.chain.ends.len()..] {
                self.chain.add(segment);
            }
            timed.curve = self.chain.curve.clone();
        }
    }

    pub fn start_follow(&mut self, fifo: usize) {
        let data = &self.follow.fifos[fifo];
        let slave = Slave::new(data, fifo, self.follow.dir, self.follow.begin, self.x);
        (self.follow.fifo, self.follow.passes, self.began, self.ending) = (fifo, 0, true, Why::End);
        self.filter = None;
        self.motion = Some(Motion::Slave(Box::new(slave)));
    }
}
