// Films in a page have the theme of the page.
{
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const films = document.querySelectorAll(".film iframe");

  const tell = (film) => {
    const chosen = document.body.dataset.theme;
    const theme = chosen === "light" || chosen === "dark" ? chosen : dark.matches ? "dark" : "light";
    film.contentWindow.postMessage({ rigidTheme: theme }, "*");
  };
  const tellAll = () => films.forEach(tell);

  films.forEach((film) => film.addEventListener("load", () => tell(film)));
  new MutationObserver(tellAll).observe(document.body, { attributeFilter: ["data-theme"] });
  dark.addEventListener("change", tellAll);
  tellAll();
}
