/* MPU-6050 to serial lines that can be trusted: numbered, time-stamped, with a checksum.

   Wiring (5 V boards with a breakout that has a regulator): VCC, GND, SDA to A4, SCL to A5 on an
   Uno or Nano. Speed of the serial line: 115200 baud. In the configuration:

       sensor: mpu-6050
       record: {device: mpu-6050, baud: 115200}

   Lines:

       #turntable v1 mpu6050 fs_a=2 fs_g=250 odr=100 id=0x68
       S,n,micros,ax,ay,az,gx,gy,gz,temp*crc8

   n counts samples from 0, micros is the board's clock, readings and temperature are the chip's
   words, crc8 (x^8 + x^2 + x + 1, start 0) covers everything before the star. The first line is
   repeated every 10 s for readers that come late. No library but Wire is needed.

   The registers are those of the MPU-6000/MPU-6050 register map, revision 4.2. */

#include <Wire.h>

const uint8_t ADDRESS = 0x68;  // 0x69 with pin AD0 high
const uint8_t ACCELEROMETER_RANGE = 0;  // 0: 2 g, 1: 4 g, 2: 8 g, 3: 16 g
const uint8_t GYROSCOPE_RANGE = 0;      // 0: 250, 1: 500, 2: 1000, 3: 2000 degrees per second
const uint8_t LOW_PASS = 3;             // 44 Hz accelerometer, 42 Hz gyroscope; both at 1 kHz
const uint16_t RATE_HZ = 100;           // divides 1000
const uint32_t BAUD = 115200;

const uint8_t SMPLRT_DIV = 0x19, CONFIG = 0x1A, GYRO_CONFIG = 0x1B, ACCEL_CONFIG = 0x1C;
const uint8_t INT_ENABLE = 0x38, INT_STATUS = 0x3A, ACCEL_XOUT_H = 0x3B;
const uint8_t PWR_MGMT_1 = 0x6B, WHO_AM_I = 0x75;
const uint8_t GYRO_CLOCK = 0x01;  // the clock follows the gyroscope's, steadier than the other
const uint8_t DATA_READY = 0x01;

uint32_t n = 0;
char line[96];

void put(uint8_t reg, uint8_t value) {
  Wire.beginTransmission(ADDRESS);
  Wire.write(reg);
  Wire.write(value);
  Wire.endTransmission();
}

// Reads count bytes from reg on; false where the chip does not answer.
bool get(uint8_t reg, uint8_t *into, uint8_t count) {
  Wire.beginTransmission(ADDRESS);
  Wire.write(reg);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(ADDRESS, count) != count) return false;
  for (uint8_t i = 0; i < count; i++) into[i] = Wire.read();
  return true;
}

uint8_t crc8(const char *text) {
  uint8_t crc = 0;
  for (; *text; text++) {
    crc ^= (uint8_t)*text;
    for (uint8_t bit = 0; bit < 8; bit++) crc = crc & 0x80 ? (crc << 1) ^ 0x07 : crc << 1;
  }
  return crc;
}

void print_header() {
  uint8_t id = 0;
  get(WHO_AM_I, &id, 1);  // clones answer other values than 0x68, and work
  snprintf(line, sizeof line, "#turntable v1 mpu6050 fs_a=%d fs_g=%d odr=%u id=0x%02X",
           2 << ACCELEROMETER_RANGE, 250 << GYROSCOPE_RANGE, (unsigned)RATE_HZ, (unsigned)id);
  Serial.println(line);
}

void start_sensor() {
  put(PWR_MGMT_1, 0x80);  // reset
  delay(100);
  put(PWR_MGMT_1, GYRO_CLOCK);
  delay(50);
  put(SMPLRT_DIV, 1000 / RATE_HZ - 1);
  put(CONFIG, LOW_PASS);
  put(GYRO_CONFIG, GYROSCOPE_RANGE << 3);
  put(ACCEL_CONFIG, ACCELEROMETER_RANGE << 3);
  put(INT_ENABLE, DATA_READY);
}

void setup() {
  Serial.begin(BAUD);
  Wire.begin();
  Wire.setClock(400000);
  start_sensor();
}

void loop() {
  uint8_t status = 0, b[14];
  if (!get(INT_STATUS, &status, 1)) {  // a loose wire: say so, and try again
    Serial.println(F("#turntable v1 mpu6050 does not answer: check its wires"));
    delay(1000);
    start_sensor();
    return;
  }
  if (!(status & DATA_READY)) return;
  uint32_t now = micros();  // when the readings became ready, to some hundred microseconds
  if (!get(ACCEL_XOUT_H, b, sizeof b)) return;
  if (n % (10UL * RATE_HZ) == 0) print_header();
  int16_t w[7];  // ax ay az temperature gx gy gz
  for (uint8_t i = 0; i < 7; i++) w[i] = (int16_t)((uint16_t)b[2 * i] << 8 | b[2 * i + 1]);
  snprintf(line, sizeof line, "S,%lu,%lu,%d,%d,%d,%d,%d,%d,%d", (unsigned long)n,
           (unsigned long)now, w[0], w[1], w[2], w[4], w[5], w[6], w[3]);
  uint8_t crc = crc8(line);
  snprintf(line + strlen(line), 4, "*%02X", (unsigned)crc);
  Serial.println(line);
  n++;
}
