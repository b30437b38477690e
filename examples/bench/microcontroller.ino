// Two fingers with four strain gauges each, two pressure sensors and two valves, at 100 Hz over USB.
//
// Every gauge is the lower half of a divider with a resistor R0 between 3.3 V and ground. What is sent is strain,
// (R / R_rest - 1) / GAUGE_FACTOR, with R_rest measured at start-up; calibrate offsets and gains afterwards. A line:
//
//     n, a0 ... a3, b0 ... b3, pa, pb       (number, strains of both fingers, pressures in kPa)
//
// A line of answer has count, time, age, stale, lost, and the pressures to command, kPa. If none arrives for 50 ms the
// valves are vented, whatever was commanded before.

const int GAUGES[8] = {A0, A1, A2, A3, A4, A5, A6, A7};
const int PRESSURES[2] = {A8, A9};
const int VALVES[2] = {5, 6};         // proportional valves, driven by PWM
const float GAUGE_FACTOR = 2.0;
const float FULL_SCALE = 210.0;       // kPa at 3.3 V of a pressure sensor, and at full duty of a valve
const unsigned long PERIOD = 10000;   // us
const unsigned long SAFE_AFTER = 50;  // ms

float rest[8];
unsigned long number = 0, due = 0, heard = 0;

float ratio(int pin) {  // R / R0 of a divider
  float share = analogRead(pin) / 4095.0;
  return share / max(1e-3f, 1.0f - share);
}

void setup() {
  Serial.begin(115200);
  Serial.setTimeout(2);
  analogReadResolution(12);
  for (int i = 0; i < 8; i++) {
    rest[i] = 0;
    for (int k = 0; k < 100; k++) rest[i] += ratio(GAUGES[i]) / 100;
  }
  due = micros();
}

void obey(String line) {
  float value[7];
  for (int i = 0, at = 0; i < 7; i++) {
    int end = line.indexOf(',', at);
    value[i] = line.substring(at, end < 0 ? line.length() : end).toFloat();
    if (end < 0 && i < 6) return;  // not a whole line
    at = end + 1;
  }
  for (int i = 0; i < 2; i++) analogWrite(VALVES[i], constrain(255 * value[5 + i] / FULL_SCALE, 0, 255));
  heard = millis();
}

void loop() {
  if (Serial.available()) obey(Serial.readStringUntil('\n'));
  if (millis() - heard > SAFE_AFTER) for (int pin : VALVES) analogWrite(pin, 0);
  if ((long)(micros() - due) < 0) return;
  due += PERIOD;
  Serial.print(number++);
  for (int i = 0; i < 8; i++) {
    Serial.print(',');
    Serial.print((ratio(GAUGES[i]) / rest[i] - 1) / GAUGE_FACTOR, 6);
  }
  for (int pin : PRESSURES) {
    Serial.print(',');
    Serial.print(FULL_SCALE * analogRead(pin) / 4095.0, 3);
  }
  Serial.println();
}
