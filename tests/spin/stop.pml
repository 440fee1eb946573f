/* Deploy (its ticks, its thread that sends, its hang watch), the guard, and the board of a head of the backend `external`:
 * docs/safety.md.
 *
 * Time passes in steps of 10 ms, in each of which every thread that can run does its work once, in any order and interleaved. The
 * environment kills deploy, halts and continues it, lets the tick hang at any point and go on, silences the camera or kills the guard:
 * FAULTS of them in all, but no deploy that dies or is halted while its guard is dead: no program would be left. The board's own
 * watchdog is left out.
 *
 * Checked in every state:
 *   bound  the head follows references for at most LATER steps while the newest tick, packet or look of the guard is older than
 *          BOUND: 0 for one fault; with two the second can hide the first for another HANG;
 *   rest   no reference takes effect after a stop until an operator activates the head.
 * tests/spin/check.py verifies both, and that one fails where MUTANT takes a part away. */
#ifndef MUTANT
#define MUTANT 0
#endif
#define LATE 2   /* deploy.watchdog.tick_late_ms: 20 */
#define HANG 4   /* hang_ms: 35 */
#define CAMERA 6 /* camera_silent_ms: 60 */
#ifndef BOUND
#define BOUND 9 /* below safe_within_ms: 100 */
#endif
#ifndef LATER
#define LATER 0
#endif
#define OLD 13   /* ages are counted up to here */
#ifndef FAULTS
#define FAULTS 1
#endif
#define ACTIVATIONS 2

mtype = { nothing, activate, reference, hold, release };
chan wire = [2] of { mtype, byte };              /* from deploy to the board, in order */
bool dead, halted, hung, camera_off, guard_dead; /* the environment's */
byte tick_age, camera_age, guard_age;            /* steps since the newest */
byte moving, activation, stopped_by_guard;       /* GuardBoard, in shared memory */
bool commands;                                   /* the tick sends references: the head is active */
bool armed, fired;                               /* HangWatch */
bool halts, stops, has_reference;                /* of ExternalRobot, for its thread that sends */
byte wanted;
byte follows;                                    /* the board: number of the activation, 0 for none */
bool moves, at_rest;                             /* a reference took effect; a stop did, after it */
bool ticked, sent, watched, looked;              /* in this step */
byte overdue;                                    /* steps for which the head has followed references beyond BOUND */

#define runs (!dead && !halted)
#define ticks (runs && !hung)
#define fault (fired || stopped_by_guard == activation || gap > LATE || \
               (MUTANT != 5 && guard_age > HANG) || (MUTANT != 4 && camera_age > CAMERA))

proctype Tick() {
  byte gap;
  do
  :: d_step { ticks && !ticked -> gap = tick_age; tick_age = 0 }
     if
     :: d_step { ticks && commands && fault -> commands = (MUTANT == 6); armed = false; stops = true; ticked = true;
                 wanted = (MUTANT == 6 -> wanted : 0);
                 moving = (MUTANT == 7 -> 0 : moving) }
     :: d_step { ticks && !commands && moving != 0 -> moving = (follows == moving -> moving : 0); ticked = true } /* released? */
     :: d_step { ticks && commands && !fault -> skip }
        d_step { ticks -> stops = false; has_reference = true; ticked = true }
     :: d_step { ticks && !commands && moving == 0 && activation < ACTIVATIONS && guard_age <= HANG && camera_age <= CAMERA && gap <= LATE ->
                 activation++; armed = false; fired = false }
        d_step { ticks -> stops = false; halts = false; has_reference = false; wanted = activation }
        if
        :: d_step { ticks && follows == activation -> tick_age = 0; moving = activation; armed = true; commands = true; ticked = true }
        :: d_step { ticks && follows != activation -> wanted = 0; ticked = true } /* no answer in time */
        fi
     :: d_step { ticks && !commands && moving == 0 -> ticked = true }
     fi
  od
}

proctype Sender() {
  mtype kind;
  byte number, told, now;
  bool told_stop;
  do
  :: d_step { runs && !sent -> kind = nothing; number = told; now = (halts -> 0 : wanted);
              if
              :: now != told && now != 0 -> kind = activate; number = now; told = now; told_stop = false
              :: now != told && now == 0 -> kind = release; told = 0
              :: now == told && told != 0 && stops -> kind = (told_stop -> nothing : hold); told_stop = true; has_reference = false
              :: now == told && told != 0 && !stops && has_reference -> kind = reference; has_reference = false; told_stop = false
              :: else
              fi }
     if
     :: d_step { runs && kind == nothing -> sent = true }
     :: d_step { runs && kind != nothing && nfull(wire) -> wire!kind,number; sent = true }
     fi
  od
}

proctype HangWatch() {
  bool hangs;
  do
  :: d_step { runs && !watched -> hangs = armed && !fired && tick_age > HANG }
     if
     :: d_step { runs && hangs -> halts = true } d_step { runs -> fired = true; watched = true }
     :: d_step { runs && !hangs -> watched = true }
     fi
  od
}

proctype Guard() {
  byte handled, found;
  do
  :: d_step { !guard_dead && !looked -> guard_age = 0;
              found = ((moving == handled || tick_age <= HANG || MUTANT == 2) -> 0 : moving) }
     if
     :: d_step { !guard_dead && found != 0 -> handled = found; follows = 0; moves = false; at_rest = true }
        d_step { !guard_dead -> stopped_by_guard = found; looked = true }
     :: d_step { !guard_dead && found == 0 -> looked = true }
     fi
  od
}

proctype Board() {
  mtype kind;
  byte number;
  do
  :: d_step { nempty(wire) -> wire?kind,number;
              if
              :: kind == activate -> follows = number; moves = false; at_rest = false
              :: kind == reference && (number == follows || MUTANT == 3) -> assert(!at_rest); moves = true
              :: (kind == hold || kind == release) && number == follows -> moves = false; at_rest = true;
                 follows = (kind == release -> 0 : follows)
              :: else
              fi }
  od
}

/* The head follows nothing and will not. */
#define idle (follows == 0 && empty(wire) && !commands)

proctype Environment() {
  byte left = FAULTS;
  do
  :: d_step { left > 0 && !dead && (!guard_dead || idle) -> dead = true; left-- }
  :: d_step { left > 0 && runs && (!guard_dead || idle) -> halted = true; left-- }
  :: d_step { halted -> halted = false }
  :: d_step { left > 0 && !hung -> hung = true; left-- }
  :: d_step { hung -> hung = false }
  :: d_step { left > 0 && !camera_off -> camera_off = true; left-- }
  :: d_step { left > 0 && !guard_dead && (runs || idle) -> guard_dead = true; left-- }
  od
}

#define older(age) age = (age < OLD -> age + 1 : OLD)

proctype Time() {
  do
  :: d_step { empty(wire) && (ticked || !ticks) && (sent || !runs) && (watched || !runs) && (looked || guard_dead) ->
              older(tick_age); older(guard_age);
              if :: camera_off -> older(camera_age) :: else -> camera_age = 0 fi;
              ticked = false; sent = false; watched = false; looked = false;
              overdue = (moves && (tick_age > BOUND || camera_age > BOUND || guard_age > BOUND) -> overdue + 1 : 0);
              assert(overdue <= LATER);
              assert(MUTANT != 9 || !(moves && activation == ACTIVATIONS)) /* 9: the head moves again after a stop */
            }
  od
}

init { atomic { run Tick(); run Sender(); run HangWatch(); run Guard(); run Board(); run Environment(); run Time() } }
