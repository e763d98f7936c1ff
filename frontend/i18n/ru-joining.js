// @ts-check
// Russian for what joining the recordings of several radars says; the form is that of ru-reading.js.

/** @type {Record<string, string>} */
export default {
  "The recording {1} is named twice; leave one out.": "Запись {1} названа дважды; уберите одну.",
  "Name at least one recording.": "Назовите хотя бы одну запись.",
  "Only plots of radars can be joined, and {1} holds {2}.": "Объединяются только отметки РЛС, а в {1} — {2}.",
  "Give its files together as one recording.": "Дайте её файлы вместе как одну запись.",
  "Row 1 of {1} is row {2}.": "Строка 1 записи {1} — это строка {2}.",
  "The recording {1} has no site, so its radar stands nowhere.": "У записи {1} нет описания системы, поэтому место её РЛС неизвестно.",
  "Read it again with a `site` (POST /api/v1/recordings, from_recording_id).": "Прочитайте её заново с описанием системы `site` (POST /api/v1/recordings, from_recording_id).",
  "The recordings have the same site: radars of one name are one radar.": "Описание системы у записей одно и то же: РЛС с одним названием — одна и та же РЛС.",
  "No site has an origin in WGS-84: the places of all radars are taken as being in one local frame.": "Ни в одном описании системы нет начала координат в WGS-84: места всех РЛС считаются заданными в одной местной системе.",
  "The site of {1} has no origin and those of other recordings have one, so it is unknown where they stand to each other.": "В описании системы записи {1} нет начала координат, а в других есть, поэтому неизвестно, как они стоят друг относительно друга.",
  "Radar {1} of {2} and {3} of {4} stand at the same place, each in a local frame without an origin, so it is unknown where they stand to each other.": "РЛС {1} записи {2} и {3} записи {4} стоят в одной точке, каждый в местной системе без начала координат, поэтому неизвестно, как они стоят друг относительно друга.",
  "Give each site its `origin` in WGS-84, or places of all radars in one local frame.": "Задайте в каждом описании системы `origin` в WGS-84 или места всех РЛС в одной местной системе.",
  "No recording has a date: the times of all are taken as counting from one instant.": "Ни у одной записи нет даты: время всех считается от одного момента.",
  "It is not known when {1} began, and of other recordings it is.": "Неизвестно, когда началась запись {1}, а о других это известно.",
  "Read it again with the option `start_utc`.": "Прочитайте её заново с параметром `start_utc`.",
  "Radar {1} of {2} is called {3}.": "РЛС {1} записи {2} называется {3}.",
  "The site of {1} does not place its radar {2}; it places {3}.": "В описании системы записи {1} нет места её РЛС {2}; есть места {3}.",
  "Read it again with a site that names every radar.": "Прочитайте её заново с описанием системы, где названа каждая РЛС.",
  "Points of true paths that another recording tells for the same target and time were left out.": "Точки истинных траекторий, которые другая запись даёт для той же цели и того же времени, опущены.",
};
