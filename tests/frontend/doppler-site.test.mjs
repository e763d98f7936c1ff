import assert from "node:assert/strict";
import test from "node:test";
import { emptyTyped, layoutOf, siteFrom, typedOf } from "../../frontend/js/doppler-site.js";

const site = {
  origin: { latitude_deg: 55, longitude_deg: 37 },
  transmitters: [{ name: "TX", east_m: 40000, north_m: 0, up_m: 12 }],
  receivers: [{ name: "RX1", east_m: 0, north_m: -150 }, { name: "RX2", east_m: 0, north_m: 150 }],
  wavelength_m: 1, sigma_doppler_hz: null,
};

test("a site that was typed is the site that was told, and what the form does not know stays", () => {
  const typed = typedOf(site);
  assert.equal(layoutOf(typed), "1x2");
  typed.receivers[0].north_m = "\u2212150,5";
  typed.sigma_doppler_hz = " 0,2 ";
  const { site: made } = siteFrom(typed, site);
  assert.deepEqual(made, { ...site, receivers: [{ name: "RX1", east_m: 0, north_m: -150.5, up_m: 0 }, { name: "RX2", east_m: 0, north_m: 150, up_m: 0 }], sigma_doppler_hz: 0.2 });
});

test("the first field that is no number is named, and nothing is guessed", () => {
  const typed = typedOf(site);
  typed.receivers[1].east_m = "12 km";
  assert.deepEqual(siteFrom(typed, null), { wrong: "receivers.1.east_m" });
  assert.deepEqual(siteFrom(emptyTyped("1x2"), null), { wrong: "transmitters.0.east_m" });
  for (const text of ["", "0", "-1", "1 m"]) assert.deepEqual(siteFrom({ ...typedOf(site), wavelength_m: text }, null), { wrong: "wavelength_m" }, text);
  assert.deepEqual(siteFrom({ ...typedOf(site), sigma_doppler_hz: "0" }, null), { wrong: "sigma_doppler_hz" });
});

test("another layout keeps what was typed", () => {
  const four = emptyTyped("2x2", typedOf(site));
  assert.equal(layoutOf(four), "2x2");
  assert.equal(four.transmitters[0].east_m, "40000");
  assert.deepEqual(four.transmitters[1], { name: "TX2", east_m: "", north_m: "", up_m: "0" });
  assert.deepEqual(emptyTyped("1x1", four).receivers, [typedOf(site).receivers[0]]);
});

test("places on the globe are not for this form", () => {
  assert.equal(typedOf({ transmitters: [{ name: "TX", latitude_deg: 55, longitude_deg: 37 }], receivers: site.receivers }), null);
  assert.equal(typedOf({}), null);
});
