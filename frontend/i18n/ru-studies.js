// @ts-check
// Russian for studies: what the papers claim, and why a claim holds or not.

/** @type {Record<string, string>} */
export const words = {
  "Accuracy with and without the flight altitude": "Точность с высотой полёта и без неё",
  "Range-difference filter without altitude (RDF) and with it (RDFV) along the reconstructed track, altitude errors from 10 m to 3 km: error in the plan by leg, gain, and how honest the filter's own claim is.": "Разностно-дальномерный фильтр без высоты (RDF) и с ней (RDFV) вдоль восстановленной трассы, ошибки высоты от 10 м до 3 км: плановая ошибка по участкам, выигрыш и честность заявленной ошибки.",
  "figure 3": "рисунок 3",
  "the altitude raises the accuracy in the plan, most where the geometry is good": "высота повышает точность в плане, сильнее всего при хорошей геометрии",
  "1.5 to 2.5 times": "в 1,5–2,5 раза",
  "an altitude error of hundreds to thousands of metres brings no substantial gain": "при ошибке высоты от сотен метров до километров существенного выигрыша нет",
  "no gain": "нет выигрыша",
  "the difference is small at the start, because the filters settle": "в начале разница мала, потому что фильтры устанавливаются",
  "small, then full": "мала, затем полная",
  "the filter's own DRMS is its error in the plan": "вычисленное фильтром DRMS – его плановая ошибка",
  "claimed = actual": "заявленная = фактическая",
  "times": "раз",
};

/** @type {Record<string, string>} */
export const sentences = {
  "With 10 m the error of the inbound leg is {1} times smaller, of the outbound one {2} times.": "При 10 м ошибка на участке приближения меньше в {1} раза, на участке удаления – в {2} раза.",
  "300 m still bring {1} times on the inbound leg, because white altitude noise is averaged; 3000 m bring {2} times.": "300 м ещё дают выигрыш в {1} раза на участке приближения, потому что белый шум высоты усредняется; 3000 м – в {2} раза.",
  "The DRMS that the model allows differs {1} times at the first mark, {2} times after 50 s.": "Достижимое в этой модели DRMS различается в {1} раза на первой отметке, в {2} раза через 50 с.",
  "Actual over claimed is {1} on the straight leg, {2} in the orbit (100 m).": "Фактическая ошибка к заявленной: {1} на прямой, {2} на кружении (100 м).",
};
