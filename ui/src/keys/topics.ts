/**
 * What the studio can do, in words: one table, which the help searches. A command stands in braces where its key is to be
 * written, so that keys are in the table of commands alone; every command stands in some topic.
 */
import type { Screen } from "../state/store";
import { COMMANDS, type Command } from "./commands";

export interface Topic {
  id: string;
  title: string;
  /** What people of the field type when they look for it: other systems' words, and those of the problem. */
  also: string;
  /** Where it is done; null: everywhere. */
  screen: Screen | null;
  /** What to do; {id} is the key of a command. */
  text: string;
}

export const TOPICS: readonly Topic[] = [
  // Begin
  { id: "begin", title: "Open a trial", also: "start load session file project browse", screen: "home", text: "Home lists the sessions with their trials, and files. {trial-next} and {trial-before} go from trial to trial, {trial-open} opens the one that is marked. From anywhere, {commands} finds a trial by its name, and {home} comes back here." },
  { id: "new-session", title: "New session from recordings", also: "import videos folder create init day subject capture", screen: "new", text: "{new} lists the folders that hold recordings and no session yet. Choose the one of a day. The program proposes what each recording is, the cameras, the rate and the fields, with reasons: correct what is wrong, and answer what no file tells. {session-make} writes session.toml; an existing one is never written over." },
  { id: "drop", title: "Look at a file of another system", also: "c3d trc tdf vicon qualisys btsbioengineering cortex nexus open import audit check upload", screen: "home", text: "Drop a C3D, TRC or TDF file on Home, or choose it there. Its swaps, spikes and gaps are listed and can be mended like those of a session's trial. The file itself is never changed: a copy is kept, and what is written has a name of its own." },
  { id: "run", title: "Run a trial", also: "process compute track reconstruct pipeline start calculate xyz reprocess again stale", screen: "home", text: "On Home, the arrow at the end of a trial's line runs it: detect, match, reconstruct, track, label, fill, judge. On Detect and Digitise {detect-run} does the same. What was edited counts in the next run too. A run can be stopped; it goes on where it was." },
  { id: "states", title: "What the state of a trial says", also: "not run tracked filled done signed failed stale verdict green amber red", screen: "home", text: "Not run: only recordings are there. Tracked and filled: results are there. Stale: something it depends on changed since, run it again. Done: nothing is left that is worth a look. Signed: a person has said so. Failed: its line says why." },
  // Cameras
  { id: "calibrate", title: "Calibrate the cameras", also: "calibration wand dlt l-frame lframe rods grid charuco checkerboard residual camera parameters compute", screen: "cameras", text: "{cameras} shows how the cameras of the session are calibrated and how good that is. {calibrate} does it now, the way that session.toml says: wand and L-frame, control balls, rods or a grid. Read the verdict first; it says what to do where it is not green." },
  { id: "calibration-good", title: "Is the calibration good?", also: "error residual accuracy precision verdict moved camera bumped rms reprojection quality lost what if", screen: "cameras", text: "The verdict is in words. Below it: the residual of each camera in pixels, the error in the volume in mm, and what is left when a camera is lost (press What if it is lost). A camera with a residual far above the others has usually been moved: calibrate again, or leave it out." },
  { id: "balls", title: "Point at the control balls", also: "control points object dlt click um2as calibration balls snap reference marker not seen", screen: "cameras", text: "{ball-point} opens the images. Click any white pixel of the ball that is asked for; the program takes the middle of the spot. {ball-none} says that the camera does not see it, {ball-next} and {ball-previous} go to another one, {ball-back} takes the last answer back. The reference marker comes last and may be left out." },
  { id: "ball-threshold", title: "White pixels of the control images", also: "threshold grey level binarise brightness", screen: "cameras", text: "Move the slider until every ball is one white spot and nothing else is white. Keep for one camera, or Keep for all, writes it into session.toml. Tick black on white where balls are darker than their ground." },
  { id: "as-found", title: "See the calibration target as it is found", also: "rods grid wand l-frame recognised target image detected why not", screen: "cameras", text: "As found, at the top of the screen, shows rods, wand, grid and L-frame on the images of any camera and frame: the markers that were recognised, joined, and all other bright spots ringed; where nothing is, why not." },
  { id: "another-way", title: "Calibrate another way", also: "change calibration method other wand rods points single marker file", screen: "cameras", text: "Another way …, at the top of the screen, lists the recordings that could calibrate the session, and asks what no file tells. Change to it writes that into session.toml; then calibrate with {calibrate}." },
  { id: "aspect", title: "Aspect ratio of the pixels", also: "square pixels bar rotating factor um2as v multiply", screen: "um2as", text: "{um2as} opens the menu; under Camera Information is Aspect Ratio. Choose the recording of a bar of markers that is turned before each camera, and press Measure. Multiply V by writes the factor into session.toml, and the menu says which files are to be made again." },
  { id: "numbers", title: "Wand length and other measures", also: "wand mm length rod distance l-frame scale measured", screen: "cameras", text: "What was measured stands under What was measured. Type the value anew, in mm, and calibrate again with {calibrate}. A wand that is 1 % too long makes every distance 1 % too long." },
  // Detect
  { id: "threshold", title: "Change the threshold", also: "grey level brightness dim missing markers detection sensitivity intensity too many too few", screen: "detect", text: "{detect} shows the images of all cameras with what is found. {detect-lower} and {detect-raise} move the threshold by 1, the slider by more; this frame is detected again at once. Nothing is written before {detect-apply}; {detect-forget} forgets what was tried. Choose a camera under For to set it apart." },
  { id: "why-marker", title: "Why is this a marker, or none?", also: "missing not detected refused too small too large not round reflection ghost blob", screen: "detect", text: "Click on the place in the image: the answer gives the grey level there, the threshold, the size in pixels, and the value with which it would be a marker. A ring is a marker, a cross is none. {detect-white} shows the white pixels." },
  { id: "mask", title: "Mask a lamp or a reflection", also: "exclude area region ignore reflections lights window paint polygon", screen: "detect", text: "Press {detect-mask}, then drag a rectangle over it in the image; {up} ends painting. What lies in a mask is no marker. {detect-apply} writes the masks to their file; its comments stay." },
  { id: "detect-frames", title: "Go through the images", also: "scroll frame video step forward back", screen: "detect", text: "{detect-forward} and {detect-back} show the next frame and the one before, {detect-forward-10} and {detect-back-10} go ten frames. The bar below the images goes anywhere." },
  // Digitise
  { id: "digitise", title: "Digitise by hand", also: "manual digitizing digitize um2as marker coordinate click point no tracker answers", screen: "digitise", text: "{digitise} asks one question at a time: where is this marker? Click any white pixel of it. Without a mouse, {digitise-next} and {digitise-before} choose a spot and {digitise-spot} points at it. {digitise-yes} takes what the other cameras say, at the +, where their lines meet." },
  { id: "um2as", title: "Work by the menu of UM²AS", also: "guided step menu manitoba upper limb camera information data calculation xyz euler angles", screen: "um2as", text: "{um2as} opens the menu as the thesis has it: Camera Information, then Data Calculation. Each entry says whether it is done and what it waits for. Enter goes into an entry, {um2as-process} does the task that is open, {up} goes one level up; it is left from the top alone. {um2as-on} and {um2as-back} go through the frames of a file." },
  { id: "skip", title: "Digitise every second frame only", also: "skip frames skipped every nth last frame number rate fewer start up", screen: "digitise", text: "Before the first answer, Start up says which frames are digitised: one of every 2, 3 … of the recording, and the last of them. They are counted 1, 2, 3, and the rate of the trial is so many times lower." },
  { id: "absent", title: "The marker is not present", also: "hidden occluded covered out of view not seen missing", screen: "digitise", text: "{digitise-absent} says that this camera does not see the marker in this frame. It is asked for again when it should be back." },
  { id: "digitise-verify", title: "Verify a frame", also: "check save review yes no confirm successfully detected all markers", screen: "digitise", text: "When all markers are found, {digitise-save} saves the frame. {digitise-verify} first goes through it marker by marker: {digitise-yes} or {digitise-no}, and after no, the very place. {digitise-hand} asks for all of it by hand. A tone says that the last frame of a camera is saved." },
  { id: "digitise-back", title: "Change a frame that is saved", also: "wrong click mistake undo correct revisit again", screen: "digitise", text: "{digitise-undo} takes the last answer back, as often as you like. {digitise-back} and {digitise-forward} show other frames, {digitise-again} changes a saved one, and {digitise-here} goes back to the frame that is asked about. Every answer is on disk before the next question: the browser may be closed at any time." },
  // Problems
  { id: "problems", title: "Be led from problem to problem", also: "errors mistakes list review check next fix mend clean", screen: "tracks", text: "{tracks} lists what is probably wrong, what costs most first. {next} goes to the next, {previous} to the one before. A is how it is, B how else it could be, dashed. {accept} takes what is proposed; {take-1} {take-2} {take-3} {take-4} {take-5} take one of the ways by its number; {right} says that it is right as it is, {later} puts it off. Stop where the list says that looking on is not worth it." },
  { id: "swap", title: "Two markers are exchanged", also: "swap switch crossover crossed identity mix-up mislabelled wrong marker flip", screen: "tracks", text: "Select both: click one, then the other with Shift. Go to the frame where it begins, and {exchange} exchanges them from there on, or in the marked stretch only. {sides} exchanges all left and right markers of the marker set." },
  { id: "ghost", title: "It is not a marker", also: "ghost reflection phantom extra delete remove erase trajectory noise unlabeled", screen: "tracks", text: "{drop} takes the selected track away. With a marked stretch it erases the samples of that stretch only. Nothing is lost: {undo} brings it back." },
  { id: "cut", title: "Cut a track in two", also: "split break snip trajectory divide separate", screen: "tracks", text: "Go to the frame where another marker begins, and press {cut}: from there to the end is marked. Then {name} names that part, or {unname} takes its name away." },
  { id: "spike", title: "A spike or a jump", also: "outlier jitter leap noise peak artefact artifact glitch", screen: "tracks", text: "Mark the frames of the spike with {mark-first} and {mark-last}, erase them with {drop}, and fill the gap with {fill}. {fourth} shows the residual instead of the speed: a jump with a large residual is one camera's fault." },
  { id: "stretch", title: "Mark a stretch of frames", also: "select range region from to interval", screen: "tracks", text: "{mark-first} marks from the frame that is shown, {mark-last} to it; or drag in the lanes below. {up} takes the marks away. What names, exchanges, erases or smooths then does so within the stretch only." },
  { id: "smooth", title: "Smooth a stretch", also: "filter low-pass butterworth woltring spline moving average noise cutoff", screen: "tracks", text: "Select a marker, mark the stretch with {mark-first} and {mark-last}, and press {smooth}: choose the function and the cut-off in Hz. For angles, choose the smoothing on the screen Angles instead: there it leaves the markers as they were measured." },
  { id: "put", title: "Put a point by hand", also: "place add insert set coordinate missing sample click image reconstruct manually", screen: "tracks", text: "Select the marker, go to the frame and press {put}. Click the marker in two images or more, or type X, Y and Z in mm. {up} ends it." },
  { id: "event", title: "Mark an event", also: "heel strike foot strike toe off gait event foot contact", screen: "tracks", text: "Go to the frame and press {event}. {event-next} and {event-back} go from event to event. Cycles of the angles run from event to event." },
  // Names
  { id: "rename", title: "Rename a marker", also: "relabel name label identify call assign identity unlabelled", screen: "tracks", text: "Select the track: click it in the view, or step with {marker-next} and {marker-back}. {name} names it; where the name is another track's already, the dialog says before whether the two go together. {unname} takes the name away." },
  { id: "labels", title: "Name all markers", also: "label auto-label autolabel marker set template subject assign identify propose", screen: "labels", text: "{labels} shows the marker set and a proposal for each track with its probability. Of a file that is of no session, {labels-ask} asks for them: by templates and labelled trials in its folder, and by the names that it has. {labels-accept} accepts all that are sure; {label-next} and {label-previous} go through the rest, {label-take} takes the name that is proposed, {name} gives another. {sides} exchanges left and right." },
  { id: "join", title: "Join two pieces of one marker", also: "merge connect fragment broken track combine stitch", screen: "tracks", text: "Give the second piece the name of the first with {name}. The dialog says before whether the two go together: overlap, gap, jump in mm. Often it stands in the list of problems already: {accept}." },
  { id: "sides", title: "Left and right are exchanged", also: "mirror side swap l r whole body", screen: "labels", text: "{sides} exchanges all pairs of left and right markers, in the whole trial or in the marked stretch." },
  // Gaps
  { id: "gaps", title: "Fill gaps", also: "gap interpolate missing spline pattern rigid body occlusion hole", screen: "gaps", text: "{gaps} lists every gap with the error that is expected of each way to fill it. {gap-all} fills all below the limit. {gap-next} and {gap-previous} go from gap to gap, {gap-fill} fills the one shown, {method} shows another way. On Tracks, {fill} fills the gap of the selected marker at the frame that is shown." },
  { id: "open", title: "Leave a gap open", also: "do not fill skip unfilled", screen: "gaps", text: "{open} leaves it open, and it is not proposed again. A gap whose expected error is above what your question bears is better left open." },
  { id: "gap-error", title: "What the expected error of a gap means", also: "mm accuracy trust hold-out holdout reliability filled error band", screen: "gaps", text: "Each way is tried on gaps of the same length made in frames where the marker was seen, and its error there is what is shown, in mm. In the images, the + is where the fill would be: a spot that belongs to nobody on the + proves it." },
  // Looking
  { id: "time", title: "Play, and go to a frame", also: "video scrub timeline playback jump speed step", screen: "tracks", text: "{play} plays; {forward} and {back} go one frame, {forward-10} and {back-10} ten, {start} and {end} to the ends. On Angles, {frame-on} and {frame-back} step and {play-angles} plays. A number typed into the frame field goes there." },
  { id: "view", title: "Look at it from elsewhere", also: "3d camera rotate turn zoom perspective angle view front side top centre center", screen: "tracks", text: "Drag turns, the wheel comes nearer. {side} goes from side to front to top, {focus} looks at what is selected, {alone} hides the others, {bands} shows or hides the 95 % ellipsoids and bands." },
  { id: "images", title: "Images and epipolar lines", also: "video camera picture overlay ray line follow zoom crop", screen: "tracks", text: "{images} shows or hides the cameras' images, {lines} the epipolar lines of the selected marker. {follow} keeps the marker in the middle of each image, larger." },
  { id: "layout", title: "Arrange the screen", also: "panes window size larger curves list", screen: "tracks", text: "{layout-1} shows all, {layout-2} the view, {layout-3} the cameras, {layout-4} the curves. Borders between areas can be dragged, or moved with the arrows when they have the focus. {whole} shows the curves of the whole trial again." },
  // Angles
  { id: "angles", title: "Joint angles", also: "kinematics knee elbow shoulder flexion euler cardan model gait curve", screen: "angles", text: "{angles} takes the joint angles of the trial as it is now. Choose the model, the smoothing, and cycles; shaded is the 95 % band, between dashed lines normal motion. {frame-on} is the next frame, {frame-back} the one before." },
  { id: "leap", title: "An angle leaps: why?", also: "spike jump outlier provenance cause", screen: "angles", text: "Click the leap in the curve. The answer names the marker that made it, the frame, and the camera whose image is farthest off. {spike-look} goes to it in Tracks." },
  { id: "euler", title: "Write the Euler angle files", also: "shd elb wst um2as export file", screen: "angles", text: "{euler} writes UM²AS's .shd, .elb and .wst of the model feeding-arm, without sign where that is ticked." },
  // End
  { id: "track-again", title: "Track again with what I said", also: "retrack reprocess pins neighbourhood correction again", screen: "tracks", text: "A name, a cut, a point put or erased is a fact for the tracker too. {again} tracks the trial again with all of them, so that one correction mends what lies about it. It is an act like others: undo takes it back." },
  { id: "finish", title: "Finish, and write the C3D", also: "export save output trim done result", screen: "tracks", text: "{finish} drops what has no name, trims to the frames that all markers share, and writes a C3D beside the file or in the session's results. Nothing is written over what was given." },
  { id: "sign", title: "Sign a trial", also: "approve approved signature audit gcp final", screen: "history", text: "{sign} says, with your name and the time, that the trial is right as it is. Whoever edits it afterwards takes the signature away; the journal keeps both." },
  { id: "report", title: "Report, and its PDF", also: "print pdf paper page quality accuracy verdict a4", screen: "report", text: "{report} shows the report of the last run. {print} prints the page that is shown; {pdf} makes a PDF of the report of A4 pages where Chromium is on this computer. kinemark pdf does the same in the terminal." },
  { id: "history", title: "Who said what, and when", also: "journal log audit trail versions difference compare diff changes", screen: "history", text: "{history} lists all that was said of the trial: who, when, why, and what became of it after the last run. Choose two versions to see what differs. {why} adds a note to what you do next." },
  { id: "undo", title: "Undo", also: "back revert mistake wrong redo restore ctrl z", screen: null, text: "{undo} takes the last act back, {redo} does it again, also tomorrow. On History, any one entry can be undone by itself." },
  { id: "saved", title: "Is it saved?", also: "save ctrl s lost crash closed browser", screen: null, text: "Always. Every act is on disk before the page shows it; at the top right stands when. Close the browser or lose the power: nothing that was answered is lost." },
  // The page
  { id: "keys", title: "Keys, menus and help", also: "shortcut shortcuts hotkey keyboard command palette search manual f1", screen: null, text: "The line at the foot always says what the next keys would do. {commands} finds every command, marker and trial by a few letters. {help} opens this help; All keys lists the keys." },
  { id: "escape", title: "One level up", also: "escape cancel close leave quit exit back", screen: null, text: "{up} goes one level up everywhere: it closes what is open, takes away the marks, then the selection, then goes to Tracks, then Home. The studio itself ends in the terminal, with Ctrl+C." },
  { id: "letters", title: "Single letters off", also: "voice input accessibility speech wcag disable switch off", screen: null, text: "Under All keys, untick Single letters do something. {commands} still reaches every command." },
  { id: "theme", title: "Light or dark", also: "theme colours contrast night", screen: null, text: "The button at the top right changes between light, dark, and what the computer says." },
];

/** The commands that a topic speaks of, in its order. */
export const commandsOf = (topic: Topic): Command[] =>
  [...new Set([...topic.text.matchAll(/\{([\w-]+)\}/g)].map((m) => m[1]!))].flatMap((id) => COMMANDS.filter((c) => c.id === id));

/** Without what makes them plural. */
const words = (text: string): string[] => text.toLowerCase().replace(/\{[\w-]+\}/g, " ").split(/[^\p{L}\p{N}²-]+/u).map((w) => w.replace(/(?<=..)s$/, "")).filter(Boolean);

/** How well a word that was typed says what a topic is: by its title, its other words, its commands, its text; 0: not at all.
 * Whole words are worth more than begun ones, and of the other words those that come first. */
function weight(topic: Topic, typed: string): number {
  const places = [topic.title, topic.also, commandsOf(topic).map((c) => c.title).join(" "), topic.text].map(words);
  const at = places.findIndex((all) => all.some((w) => w.startsWith(typed)));
  if (at < 0) return 0;
  const all = places[at]!, whole = all.indexOf(typed), begun = all.findIndex((w) => w.startsWith(typed));
  return 4 ** (places.length - at) * (whole >= 0 ? 2 : 1) + 1 / (1 + (whole >= 0 ? whole : begun));
}

/** Topics that all the words speak of, best first; of the screen that is on first where that leaves a choice. */
export function find(typed: string, screen: Screen | null = null): Topic[] {
  const asked = words(typed);
  return TOPICS.map((topic, i) => ({ topic, i, each: asked.map((w) => weight(topic, w)), here: topic.screen === screen ? 0 : 1 }))
    .filter(({ each }) => each.every((w) => w > 0))
    .sort((a, b) => sum(b.each) - sum(a.each) || a.here - b.here || a.i - b.i)
    .map(({ topic }) => topic);
}

const sum = (all: readonly number[]): number => all.reduce((a, b) => a + b, 0);
