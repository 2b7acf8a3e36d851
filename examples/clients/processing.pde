// Processing: a circle that jumps at every onset, turns red at moves, sways with steps, pales at rest, and has a ring for the progress of a followed move. Not run here: there was no Processing.
// Start: mossar run SOURCE --to osc://127.0.0.1:9000   Needs the library oscP5 (Sketch, Import Library).
import oscP5.*;

float size = 60;
float sway = 0;
color filling = color(230, 159, 0);
boolean moving = true;
float progress = 0;
String said = "waiting for /mossar/key_frame at port 9000";

void setup() {
  size(640, 360);
  new OscP5(this, 9000);
}

void draw() {
  background(20, 32, 43);
  size = lerp(size, 60, 0.08);
  fill(filling, moving ? 255 : 120);
  noStroke();
  circle(width / 2 + sway, height / 2, size);
  noFill();
  stroke(86, 180, 233);
  strokeWeight(6);
  arc(width / 2, height / 2, 280, 280, -HALF_PI, -HALF_PI + TWO_PI * progress);
  fill(232);
  text(said, 20, 30);
}

void oscEvent(OscMessage message) {
  if (message.checkAddrPattern("/mossar/key_frame")) keyFrame(message);
  if (message.checkAddrPattern("/mossar/move")) move(message);
  if (message.checkAddrPattern("/mossar/step")) step(message);
  if (message.checkAddrPattern("/mossar/follow")) follow(message);
  if (message.checkAddrPattern("/mossar/pose")) pose(message);
  if (message.checkAddrPattern("/mossar/activity") && message.get(1).stringValue().equals("body"))
    moving = message.get(2).stringValue().equals("moving"); // performer, channel, state, take, start, decided_time, previous
}

// performer, status, name, limb that strays most, joint, take, count, progress, tempo, certainty, deviation, score, start, time, decided_time, id, rev, limbs
void follow(OscMessage message) {
  String status = message.get(1).stringValue();
  boolean over = status.equals("done") || status.equals("left");
  progress = over ? 0 : message.get(7).floatValue();
  if (status.equals("done")) said = message.get(2).stringValue() + "  " + message.get(6).intValue();
}

// performer, status, name, limb that strays most, joint, take, start, seconds, deviation, decided_time, id, rev, limbs
void pose(OscMessage message) {
  if (message.get(1).stringValue().equals("held")) said = message.get(2).stringValue() + "  held";
}

// performer, status, side, take, time, decided_time, confidence, x, y, z, id
void step(OscMessage message) {
  if (message.get(1).stringValue().equals("strike")) sway = message.get(2).stringValue().equals("left") ? -20 : 20;
}

// performer, status, name, limb, take, start, end, decided_time, score, rev
void move(OscMessage message) {
  if (!message.get(1).stringValue().equals("confirmed")) return;
  said = message.get(0).stringValue() + "  " + message.get(2).stringValue();
  filling = color(213, 94, 0);
}

// performer, status, kind, take, frame, time, decided_time, velocity, strength, rev
void keyFrame(OscMessage message) {
  String status = message.get(1).stringValue();
  String kind = message.get(2).stringValue();
  if (!status.equals("confirmed")) return;
  said = message.get(0).stringValue() + "  " + kind + "  " + nf(message.get(5).floatValue(), 0, 2) + " s";
  filling = color(230, 159, 0);
  size = kind.equals("offset") ? 120 : 240;
}
