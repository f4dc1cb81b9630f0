"""Print the handout page of a notebook to an A4 PDF."""

import html

from playwright.sync_api import Browser, Page, PdfMargins

from pgm_book.make.browser import offline_context

MARGINS: PdfMargins = {
    "top": "12mm",
    "bottom": "15mm",
    "left": "15mm",
    "right": "15mm",
}

_FOOTER = """\
<div style="width: 100%; margin: 0 15mm; display: flex; font: 8pt sans-serif;
            color: #4d5761; justify-content: space-between">
  <span>{title}</span>
  <span><span class="pageNumber"></span> / <span class="totalPages"></span></span>
</div>"""


def print_pdf(browser: Browser, content: str) -> bytes:
    """Return the PDF of an HTML page, tagged and with an outline."""
    context = offline_context(browser)
    try:
        page = context.new_page()
        page.set_content(content)
        page.wait_for_function("document.documentElement.dataset.ready")
        return pdf_of(page)
    finally:
        context.close()


def pdf_of(page: Page) -> bytes:
    """Return the PDF of a page that is open and ready."""
    return page.pdf(
        format="A4",
        margin=MARGINS,
        print_background=True,
        display_header_footer=True,
        header_template="<span></span>",
        footer_template=_FOOTER.format(title=html.escape(page.title())),
        tagged=True,
        outline=True,
    )
