// @ts-check
// Russian for what making targets of recorded tracks says; the form is that of ru-reading.js.

/** @type {Record<string, string>} */
export default {
  "A body of type {1} is not taken; send multipart/form-data.": "Тело типа {1} не принимается; пришлите multipart/form-data.",
  "{1} has no targets that follow points; these have: {2}.": "У {1} нет целей, идущих по точкам; они есть у {2}.",
  "The targets come from the file; leave them out.": "Цели берутся из файла; не указывайте их.",
  "None of {1} tracks can be a target; {2}: {3}": "Ни одна из {1} трасс не может стать целью; {2}: {3}",
  "Try again in a moment, or give a part of it.": "Повторите через мгновение или дайте его часть.",
  "This field is missing.": "Этого поля нет.",
  "The file has no track {1} with two reports or more in that time.": "В файле нет трассы {1}, у которой за это время было бы два сообщения или больше.",
  "Leave the names out to get the longest tracks with theirs.": "Не указывайте названий, чтобы получить самые длинные трассы с их названиями.",
  "No track of the file has two reports or more in that time.": "Ни у одной трассы файла нет за это время двух сообщений или больше.",
  "Widen the time, or the longest pause `gap_s`.": "Расширьте время или наибольшую паузу `gap_s`.",
  "last_s must be later than first_s": "last_s должно быть позже first_s",
  "The recording has no true paths of its own.": "У записи нет собственных истинных траекторий.",
  "What truth its rows have stands beside them, in data.csv.": "Истинные положения её строк стоят рядом с ними, в data.csv.",
};
