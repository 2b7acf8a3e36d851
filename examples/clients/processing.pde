// Processing: a circle that jumps at every onset. Not run here: there was no Processing.
// Start: mossar run SOURCE --to osc://127.0.0.1:9000   Needs the library oscP5 (Sketch, Import Library).
import oscP5.*;

float size = 60;
String said = "waiting for /mossar/key_frame at port 9000";

void setup() {
  size(640, 360);
  new OscP5(this, 9000);
}

void draw() {
  background(20, 32, 43);
  size = lerp(size, 60, 0.08);
  fill(230, 159, 0);
  noStroke();
  circle(width / 2, height / 2, size);
  fill(232);
  text(said, 20, 30);
}

// performer, status, kind, take, frame, time, decided_time, velocity, strength, rev
void oscEvent(OscMessage message) {
  if (!message.checkAddrPattern("/mossar/key_frame")) return;
  String status = message.get(1).stringValue();
  String kind = message.get(2).stringValue();
  if (!status.equals("confirmed")) return;
  said = message.get(0).stringValue() + "  " + kind + "  " + nf(message.get(5).floatValue(), 0, 2) + " s";
  size = kind.equals("offset") ? 120 : 240;
}
