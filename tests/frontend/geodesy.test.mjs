import assert from "node:assert/strict";
import test from "node:test";
import { enuToGeodetic, niceStep, rangeAzimuth } from "../../frontend/js/geodesy.js";

// Origin, east, north, up and what pymap3d 3.2 (enu2geodetic, WGS-84) gives: latitude, longitude, height.
const KNOWN = [
  [56, 37.5, 150, 0, 0, 0, 56, 37.5, 150],
  [56, 37.5, 150, 100000, 50000, 0, 56.43844454201381, 39.12108119106777, 1127.9437471903993],
  [-33.9, 151.2, 20, -250000, 30000, 1000, -33.60027283050359, 148.5080087791423, 5982.607803789929],
  [0, 179.9, 0, 50000, -20000, 0, -0.1808676936564232, -179.65085155849147, 227.54637635871876],
  [89.5, 10, 0, 10000, 80000, 0, 89.76599311492542, 167.50717328598003, 507.82474686379624],
];

test("local coordinates turn to latitude and longitude as pymap3d turns them", () => {
  for (const [latitude_deg, longitude_deg, height_m, east, north, up, ...known] of KNOWN) {
    const got = enuToGeodetic({ latitude_deg, longitude_deg, height_m }, east, north, up);
    const off = [got.latitude_deg - known[0], got.longitude_deg - known[1], (got.height_m - known[2]) * 1e-5];
    assert.ok(off.every((one) => Math.abs(one) < 1e-9), JSON.stringify({ got, known }));
  }
});

test("azimuth counts from north to east", () => {
  assert.deepEqual([[0, 5], [5, 0], [0, -5], [-5, 0]].map(([east, north]) => rangeAzimuth(east, north).azimuth_deg), [0, 90, 180, 270]);
  assert.equal(rangeAzimuth(3, 4).range_m, 5);
});

test("steps of scales are 1, 2 or 5", () => {
  assert.deepEqual([7, 11, 30, 60, 90, 0.3].map((span) => Number(niceStep(span, 5).toPrecision(6))), [2, 5, 10, 20, 20, 0.1]);
});
